//! Pairs of ports of a shaft. Its open receptance is symmetric, also where it rotates (the coupling of the planes is
//! symmetric in r = x + jy), so half of the pairs is enough: (i, j) with j ≤ i, row by row.

use super::channels::ZERO;
use crate::linalg::c64;
use crate::linalg::fused::multiply_add;

/// The pairs of ports of which the second is one of the first `driven`, at which forces act.
pub(crate) fn pairs(ports: usize, driven: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..ports).flat_map(move |i| (0..driven.min(i + 1)).map(move |j| (i, j)))
}

/// Amplitudes of each coordinate at two ports multiplied, in the order of [`pairs`]; `ports` are ports × coordinates.
pub(crate) fn products(ports: &[Vec<f64>], driven: usize) -> Vec<f64> {
    let coordinates = 0..ports.first().map_or(0, Vec::len);
    let own = |k: usize| pairs(ports.len(), driven).map(move |(i, j)| ports[i][k] * ports[j][k]);
    coordinates.flat_map(own).collect()
}

/// Σ_k products/z_k of every pair, real and imaginary parts apart; `inverses` are those of the 1/z_k.
pub(crate) fn over_coordinates(
    products: &[f64],
    inverses: impl Iterator<Item = (f64, f64)>,
    count: usize,
) -> (Vec<f64>, Vec<f64>) {
    let (mut re, mut im) = (vec![0.0; count], vec![0.0; count]);
    for (products, (own_re, own_im)) in products.chunks(count).zip(inverses) {
        for ((re, im), product) in re.iter_mut().zip(&mut im).zip(products) {
            *re = multiply_add(own_re, *product, *re);
            *im = multiply_add(own_im, *product, *im);
        }
    }
    (re, im)
}

/// The whole receptance of `ports` ports, row-major, from that of the pairs.
pub(crate) fn whole(ports: usize, receptance: &(Vec<f64>, Vec<f64>)) -> Vec<c64> {
    let (re, im) = receptance;
    let mut all = vec![ZERO; ports * ports];
    for ((i, j), (re, im)) in pairs(ports, ports).zip(re.iter().zip(im)) {
        all[i * ports + j] = c64::new(*re, *im);
        all[j * ports + i] = c64::new(*re, *im);
    }
    all
}
