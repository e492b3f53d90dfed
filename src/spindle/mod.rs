//! The machine round the shaft: bearings, electronics, effects, tool, named ports, the open-loop plant at a speed.
