//! Signs of small determinants of doubles, exact, and with ties decided by shifting every leaf a little.

use num_bigint::{BigInt, Sign};

/// At most this many rows.
pub(super) const MOST: usize = 4;

/// A square matrix of `n` rows, the rest unused.
pub(super) type Matrix = [[f64; MOST]; MOST];

/// The sign of the determinant of the first `n` rows and columns: -1, 0 or 1. Exact.
pub(super) fn sign(m: &Matrix, n: usize) -> i32 {
    let (value, size) = estimate(m, n);
    // A product of four factors and a sum of 24 such terms are off by at most 10 roundings of the sum of their absolutes.
    let bound = 16.0 * f64::EPSILON * size;
    if value.abs() > bound && size > f64::MIN_POSITIVE * 1e20 && size.is_finite() {
        return if value > 0.0 { 1 } else { -1 };
    }
    exact(m, n)
}

/// A determinant and the sum of the absolutes of its terms.
fn estimate(m: &Matrix, n: usize) -> (f64, f64) {
    match n {
        0 => (1.0, 1.0),
        1 => (m[0][0], m[0][0].abs()),
        2 => {
            let (a, b) = (m[0][0] * m[1][1], m[0][1] * m[1][0]);
            (a - b, a.abs() + b.abs())
        }
        _ => {
            let (mut value, mut size) = (0.0, 0.0);
            for k in 0..n {
                let (v, s) = estimate(&minor(m, n, k), n - 1);
                let term = m[0][k] * v;
                value += if k % 2 == 0 { term } else { -term };
                size += m[0][k].abs() * s;
            }
            (value, size)
        }
    }
}

/// Without the first row and column `k`.
fn minor(m: &Matrix, n: usize, k: usize) -> Matrix {
    let mut out = [[0.0; MOST]; MOST];
    for r in 1..n {
        for (to, c) in (0..n).filter(|c| *c != k).enumerate() {
            out[r - 1][to] = m[r][c];
        }
    }
    out
}

fn exact(m: &Matrix, n: usize) -> i32 {
    // All numbers as integers times one power of two.
    let parts = |v: f64| {
        let bits = v.abs().to_bits();
        let (e, f) = ((bits >> 52) as i64, bits & ((1 << 52) - 1));
        if e == 0 { (f, 1) } else { (f | 1 << 52, e) }
    };
    let all = || m.iter().take(n).flat_map(|r| r.iter().take(n)).copied().filter(|v| *v != 0.0 && v.is_finite());
    let Some(least) = all().map(|v| parts(v).1).min() else { return 0 };
    let whole = |v: f64| {
        if v == 0.0 || !v.is_finite() {
            return BigInt::from(0);
        }
        let (f, e) = parts(v);
        let b = BigInt::from(f) << (e - least) as usize;
        if v < 0.0 { -b } else { b }
    };
    let rows: Vec<Vec<BigInt>> = (0..n).map(|r| (0..n).map(|c| whole(m[r][c])).collect()).collect();
    match determinant(&rows).sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    }
}

fn determinant(m: &[Vec<BigInt>]) -> BigInt {
    if m.is_empty() {
        return BigInt::from(1);
    }
    let mut sum = BigInt::from(0);
    for k in 0..m.len() {
        if m[0][k] == BigInt::from(0) {
            continue;
        }
        let rest: Vec<Vec<BigInt>> =
            m[1..].iter().map(|r| r.iter().enumerate().filter(|x| x.0 != k).map(|x| x.1.clone()).collect()).collect();
        let term = &m[0][k] * determinant(&rest);
        if k % 2 == 0 {
            sum += term;
        } else {
            sum -= term;
        }
    }
    sum
}

/// Whether the first of some linear functions is positive where all others vanish. `rows` are their values at the `n` corners
/// of a simplex of which the others cut `n - 1`, so there is one such point. A value of zero, there or at a corner, counts as
/// positive, as if a number e_k were added to leaf k, with e_0 far above e_1 far above e_2 and all of them tiny; `order` are
/// the leaves' numbers.
pub(super) fn positive(rows: &Matrix, n: usize, order: &[u32]) -> bool {
    let with_ones = |k: usize| {
        let mut m = *rows;
        m[k] = [1.0; MOST];
        sign(&m, n)
    };
    let below = with_ones(0);
    let above = sign(rows, n);
    if above != 0 {
        return above == below;
    }
    let mut turns: Vec<usize> = (0..n).collect();
    turns.sort_by_key(|k| order[*k]);
    for k in turns {
        if k == 0 {
            return true;
        }
        let s = with_ones(k);
        if s != 0 {
            return s == below;
        }
    }
    true
}
