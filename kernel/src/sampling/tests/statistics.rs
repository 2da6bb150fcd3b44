//! The χ² test, and quadrature.

/// The z-score of a χ² test of `counts` against `expected`, by Wilson and Hilferty's cube-root approximation: standard
/// normal if the counts follow the expectation. Cells are pooled until each expects at least 10; a cell that expects
/// nothing must hold nothing.
pub(in crate::sampling) fn chi_squared(counts: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut cells) = (0.0, 0.0);
    let (mut count, mut expect) = (0.0, 0.0);
    let total: f64 = expected.iter().sum();
    assert!((counts.iter().sum::<f64>() - total).abs() < 1e-3 * total, "counts and expectations differ in their sums");
    for (&c, &e) in counts.iter().zip(expected) {
        assert!(e > 0.0 || c == 0.0, "{c} samples in a cell of zero probability");
        count += c;
        expect += e;
        if expect >= 10.0 {
            statistic += (count - expect) * (count - expect) / expect;
            cells += 1.0;
            (count, expect) = (0.0, 0.0);
        }
    }
    let freedom: f64 = cells - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    ((statistic / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

/// ∫ f over [x0, x1] × [y0, y1] by Gauss and Legendre's rule with 5 × 5 nodes.
pub(in crate::sampling) fn integrate([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], f: impl Fn(f64, f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189),
        (-0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.0, 0.568_888_888_888_889),
        (0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.906_179_845_938_664, 0.236_926_885_056_189),
    ];
    let (width, height) = (0.5 * (x1 - x0), 0.5 * (y1 - y0));
    let mut sum = 0.0;
    for (s, ws) in NODES {
        for (t, wt) in NODES {
            sum += ws * wt * f(x0 + width * (1.0 + s), y0 + height * (1.0 + t));
        }
    }
    sum * width * height
}

#[test]
fn chi_squared_tells_fair_from_biased() {
    // χ² = 2·(2²/50) + 2·(6²/50) = 1.6 with 3 degrees of freedom: p = .659, z = -.41.
    assert!((chi_squared(&[52.0, 48.0, 56.0, 44.0], &[50.0; 4]) + 0.41).abs() < 0.03);
    assert!(chi_squared(&[80.0, 20.0, 50.0, 50.0], &[50.0; 4]) > 4.0);
}

#[test]
fn quadrature_is_exact_to_degree_nine() {
    let value = integrate([0.0, 2.0], [-1.0, 1.0], |x, y| x.powi(9) * y.powi(8));
    assert!((value - 102.4 * 2.0 / 9.0).abs() < 1e-10);
}
