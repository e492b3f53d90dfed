//! Closed loop, dynamic stiffness, sensitivity zones, worst case, time response.
