//! Complex columns of a few entries in groups of four, real and imaginary parts apart.
//!
//! A group fills a register of a processor with 256 bits, which the type of its parts says: of arrays the compiler
//! leaves some operations to four single ones. The number of entries in it is known to the compiler, which therefore
//! unrolls what a column of any length would need a loop for; rows that fill up a group are zero.

use super::c64;

/// Four real numbers, one for each entry of a group.
pub(crate) type Reals = wide::f64x4;

/// Entries in a group.
pub(crate) const WIDTH: usize = 4;

/// Four complex numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes {
    re: Reals,
    im: Reals,
}

/// Groups that `n` entries need.
pub(crate) fn groups(n: usize) -> usize {
    n.div_ceil(WIDTH)
}

/// Group of an entry of a column, and its place in the group.
#[inline]
pub(crate) fn place(i: usize) -> (usize, usize) {
    (i / WIDTH, i % WIDTH)
}

/// Four real numbers by their places.
#[inline]
pub(crate) fn reals(at: impl Fn(usize) -> f64) -> Reals {
    Reals::new(std::array::from_fn(at))
}

/// Group `g` of a list of real numbers.
#[inline]
pub(crate) fn real_group(g: usize, at: impl Fn(usize) -> f64) -> Reals {
    reals(|l| at(WIDTH * g + l))
}

/// The sum of four numbers, in pairs.
#[inline]
pub(crate) fn sum_of(four: Reals) -> f64 {
    let four = four.as_array();
    (four[0] + four[1]) + (four[2] + four[3])
}

impl Lanes {
    pub(crate) const ZERO: Self = Self::splat(c64::new(0.0, 0.0));

    pub(crate) const ONE: Self = Self::splat(c64::new(1.0, 0.0));

    pub(crate) const fn splat(value: c64) -> Self {
        Self { re: Reals::splat(value.re), im: Reals::splat(value.im) }
    }

    /// Columns of `n` entries each, one after the other.
    pub(crate) fn columns(n: usize, count: usize, at: impl Fn(usize, usize) -> c64) -> Vec<Self> {
        let entry = |i: usize, j: usize| {
            if i < n { at(i, j) } else { c64::new(0.0, 0.0) }
        };
        let group = |j: usize, g: usize| Self::from_fn(|l| entry(WIDTH * g + l, j));
        let mut list = Vec::with_capacity(count * groups(n));
        for j in 0..count {
            list.extend((0..groups(n)).map(|g| group(j, g)));
        }
        list
    }

    #[inline]
    pub(crate) fn from_fn(at: impl Fn(usize) -> c64) -> Self {
        let four: [c64; WIDTH] = std::array::from_fn(at);
        Self { re: reals(|l| four[l].re), im: reals(|l| four[l].im) }
    }

    /// Four numbers by their real and imaginary parts.
    #[inline]
    pub(crate) fn of_parts(re: Reals, im: Reals) -> Self {
        Self { re, im }
    }

    /// A number of each of up to four items; zero for what is missing of four.
    pub(crate) fn of_list<T>(list: &[T], at: impl Fn(&T) -> c64) -> Self {
        Self::from_fn(|l| list.get(l).map_or(c64::new(0.0, 0.0), &at))
    }

    #[inline]
    pub(crate) fn reals(&self) -> (Reals, Reals) {
        (self.re, self.im)
    }

    #[inline]
    pub(crate) fn parts(&self) -> (&[f64; WIDTH], &[f64; WIDTH]) {
        (self.re.as_array(), self.im.as_array())
    }

    /// One of the four.
    #[inline]
    pub(crate) fn lane(&self, l: usize) -> c64 {
        let (re, im) = self.parts();
        c64::new(re[l], im[l])
    }

    /// Entry of a column.
    pub(crate) fn at(column: &[Self], i: usize) -> c64 {
        let (group, lane) = place(i);
        column[group].lane(lane)
    }

    #[inline]
    pub(crate) fn set_lane(&mut self, l: usize, value: c64) {
        self.re.as_mut_array()[l] = value.re;
        self.im.as_mut_array()[l] = value.im;
    }

    /// Sets an entry of a column.
    pub(crate) fn set(column: &mut [Self], i: usize, value: c64) {
        let (group, lane) = place(i);
        column[group].set_lane(lane, value);
    }

    /// x + a y.
    #[inline]
    pub(crate) fn plus(&self, a: c64, y: &Self) -> Self {
        let (re, im) = (Reals::splat(a.re), Reals::splat(a.im));
        Self { re: re.mul_add(y.re, (-im).mul_add(y.im, self.re)), im: re.mul_add(y.im, im.mul_add(y.re, self.im)) }
    }

    /// x + y.
    #[inline]
    pub(crate) fn sum(&self, y: &Self) -> Self {
        Self { re: self.re + y.re, im: self.im + y.im }
    }

    /// Each entry times a number; products are rounded before they are added, as those of single numbers.
    #[inline]
    pub(crate) fn rounded_times(&self, a: c64) -> Self {
        Self { re: self.re * a.re - self.im * a.im, im: self.re * a.im + self.im * a.re }
    }

    /// Each entry times that of another group.
    #[inline]
    pub(crate) fn product(&self, y: &Self) -> Self {
        Self { re: self.re.mul_sub(y.re, self.im * y.im), im: self.re.mul_add(y.im, self.im * y.re) }
    }

    /// Each entry plus the product of those of two other groups.
    #[inline]
    pub(crate) fn plus_product(&self, x: &Self, y: &Self) -> Self {
        Self {
            re: x.re.mul_add(y.re, (-x.im).mul_add(y.im, self.re)),
            im: x.re.mul_add(y.im, x.im.mul_add(y.re, self.im)),
        }
    }

    /// Real part of each entry times that of another group.
    #[inline]
    pub(crate) fn real_product(&self, y: &Self) -> Reals {
        self.re.mul_sub(y.re, self.im * y.im)
    }

    /// x − y.
    #[inline]
    pub(crate) fn minus(&self, y: &Self) -> Self {
        Self { re: self.re - y.re, im: self.im - y.im }
    }

    /// 1/entry.
    #[inline]
    pub(crate) fn reciprocal(&self) -> Self {
        let squares = self.squares();
        Self { re: self.re / squares, im: -self.im / squares }
    }

    /// The conjugate of each entry.
    #[inline]
    pub(crate) fn conjugate(&self) -> Self {
        Self::of_parts(self.re, -self.im)
    }

    /// Each entry times a real number of its own.
    #[inline]
    pub(crate) fn times(&self, factors: Reals) -> Self {
        Self { re: self.re * factors, im: self.im * factors }
    }

    /// |entry|².
    #[inline]
    pub(crate) fn squares(&self) -> Reals {
        self.re.mul_add(self.re, self.im * self.im)
    }

    /// Σ|entry|² of a column, or of several together.
    #[inline]
    pub(crate) fn sum_of_squares(columns: &[Self]) -> f64 {
        let mut sums = Reals::splat(0.0);
        for group in columns {
            sums += group.squares();
        }
        sum_of(sums)
    }

    /// xᴴy of two columns. Products are rounded before they are added, so that xᴴx is real.
    #[inline]
    pub(crate) fn inner(x: &[Self], y: &[Self]) -> c64 {
        let (mut re, mut im) = (Reals::splat(0.0), Reals::splat(0.0));
        for (x, y) in x.iter().zip(y) {
            re += x.re * y.re + x.im * y.im;
            im += x.re * y.im - x.im * y.re;
        }
        c64::new(sum_of(re), sum_of(im))
    }
}

/// A Hermitian matrix whose columns are groups; it is stored whole.
#[derive(Clone, Debug)]
pub(crate) struct HermitianLanes {
    n: usize,
    columns: Vec<Lanes>,
}

impl HermitianLanes {
    /// MᴴM of the matrix with these columns, each of `height` groups.
    pub(crate) fn gram(columns: &[Lanes], height: usize) -> Self {
        let n = columns.len() / height.max(1);
        let width = groups(n);
        let mut gram = Self { n, columns: vec![Lanes::ZERO; n * width] };
        let column = |j: usize| &columns[j * height..(j + 1) * height];
        for j in 0..n {
            for i in 0..=j {
                let entry = Lanes::inner(column(i), column(j));
                Lanes::set(&mut gram.columns[j * width..], i, entry);
                Lanes::set(&mut gram.columns[i * width..], j, entry.conj());
            }
        }
        gram
    }

    /// Σ|entry|².
    pub(crate) fn sum_of_squares(&self) -> f64 {
        Lanes::sum_of_squares(&self.columns)
    }

    fn column(&self, j: usize) -> &[Lanes] {
        let width = groups(self.n);
        &self.columns[j * width..(j + 1) * width]
    }

    fn trace(&self) -> f64 {
        (0..self.n).map(|j| Lanes::at(self.column(j), j).re).sum()
    }

    /// A v.
    fn times(&self, v: &[Lanes]) -> Vec<Lanes> {
        let mut product = vec![Lanes::ZERO; groups(self.n)];
        for j in 0..self.n {
            let factor = Lanes::at(v, j);
            for (sum, group) in product.iter_mut().zip(self.column(j)) {
                *sum = sum.plus(factor, group);
            }
        }
        product
    }

    /// A² over the square of a positive number, which the entries are divided by before they are multiplied.
    fn square_lanes(&self, size: f64) -> Self {
        let width = groups(self.n);
        let inverse = size.recip();
        let mut columns = Vec::with_capacity(self.columns.len());
        for j in 0..self.n {
            let own = self.column(j);
            for g in 0..width {
                let mut sum = Lanes::ZERO;
                for k in 0..self.n {
                    sum = sum.plus(Lanes::at(own, k) * inverse, &self.columns[k * width + g]);
                }
                columns.push(sum.times(Reals::splat(inverse)));
            }
        }
        Self { n: self.n, columns }
    }

    /// The largest eigenvalue of a positive semidefinite matrix with its vector of unit length: the power method,
    /// started from a column of its 16th power. NaN for entries that are not finite. Where the norm of a power shows
    /// that the eigenvalue is below `floor`, that bound stands in its place, without a vector.
    pub(crate) fn largest_above(&self, floor: f64) -> Largest {
        let mut power = self.clone();
        // A to the power `exponent` is that of `scale` times `power`.
        let (mut scale, mut exponent) = (1.0, 1.0);
        for _ in 0..SQUARINGS {
            let at_most = scale * power.sum_of_squares().powf(0.5 / exponent);
            if at_most < floor {
                return Largest::Below(at_most);
            }
            let trace = power.trace();
            if trace.is_nan() || trace <= 0.0 {
                let value = if trace.is_nan() { f64::NAN } else { 0.0 };
                return Largest::Value(value, vec![Lanes::ZERO; groups(self.n)]);
            }
            power = power.square_lanes(trace);
            scale *= trace.powf(1.0 / exponent);
            exponent *= 2.0;
        }
        let diagonal = |j: usize| Lanes::at(power.column(j), j).re;
        let largest = (1..self.n).fold(0, |k, j| if diagonal(j) > diagonal(k) { j } else { k });
        let mut v = power.column(largest).to_vec();
        // Three more steps: a second value 1 % below the largest is left with 1e-3 of the vector, 1e-6 of the value.
        for _ in 0..3 {
            v = power.times(&v);
            let inverse = Lanes::sum_of_squares(&v).sqrt().recip();
            for group in &mut v {
                *group = group.times(Reals::splat(inverse));
            }
        }
        Largest::Value(Lanes::inner(&v, &self.times(&v)).re, v)
    }
}

/// Squarings before the power method begins.
const SQUARINGS: usize = 4;

/// Largest eigenvalue of a positive semidefinite matrix.
#[derive(Clone, Debug)]
pub(crate) enum Largest {
    /// With its vector.
    Value(f64, Vec<Lanes>),
    /// It is below a floor, and at most this.
    Below(f64),
}

#[cfg(test)]
mod tests {
    use super::super::Mat;
    use super::super::hermitian::hermitian_eigen;
    use super::*;

    #[test]
    fn the_largest_eigenvalue_is_that_of_the_library() {
        for (rows, n) in [(1, 1), (3, 2), (4, 4), (7, 6), (9, 5), (5, 9)] {
            let entry = |i: usize, j: usize| c64::from_polar(1.0 / (1.0 + (i * j) as f64), (3 * i + 7 * j) as f64);
            let columns = Lanes::columns(rows, n, entry);
            let lanes = HermitianLanes::gram(&columns, groups(rows));
            let found = |floor: f64| match lanes.largest_above(floor) {
                Largest::Value(value, vector) => Ok((value, vector)),
                Largest::Below(most) => Err(most),
            };
            let (value, vector) = found(0.0).expect("nothing is below zero");
            let m = Mat::from_fn(rows, n, entry);
            let gram = m.adjoint() * &m;
            let exact = *hermitian_eigen(&gram).expect("the matrix is Hermitian").0.last().expect("it has columns");
            assert!((value / exact - 1.0).abs() < 1e-6, "{value} and {exact}");
            for floor in [0.99 * exact, 1.01 * exact, 1.2 * exact, 9.0 * exact] {
                match found(floor) {
                    Ok((again, _)) => assert_eq!(again, value),
                    Err(most) => assert!(exact <= most * (1.0 + 1e-12) && most < floor),
                }
            }
            assert!(found(0.99 * exact).is_ok() && found(9.0 * exact).is_err());
            let v = |j: usize| Lanes::at(&vector, j);
            for i in 0..n {
                let image: c64 = (0..n).map(|j| gram[(i, j)] * v(j)).sum();
                assert!((image - v(i) * exact).norm() < 1e-3 * exact);
            }
        }
    }
}
