//! Hits against independent geometry in `f64`.

use glam::Vec3;
use halfdome_kernel::{Ray, Triangle};
use halfdome_tests::check::check;
use halfdome_tests::random::Pcg;

/// Where the line of a ray crosses the plane of a triangle.
struct Crossing {
    t: f64,
    /// The least barycentric weight: positive inside the triangle.
    least: f64,
    /// The sine of the angle between ray and plane, times that between two edges.
    sine: f64,
}

/// After Möller and Trumbore 1997, in `f64`.
fn crossing(ray: &Ray, triangle: &Triangle) -> Crossing {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    let s = origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(ab);
    let v = direction.dot(q) / determinant;
    let sine = determinant.abs() / (ab.length() * ac.length() * direction.length());
    Crossing { t: ac.dot(q) / determinant, least: u.min(v).min(1.0 - u - v), sine }
}

impl Crossing {
    /// Whether rounding in 32 bits may decide: close to an edge, or at a grazing angle close to the triangle.
    fn is_doubtful(&self) -> bool {
        self.least.abs() < 1e-4 || self.sine < 0.05 && self.least > -0.5
    }

    fn is_hit(&self) -> bool {
        self.t > 0.0 && self.least > 0.0
    }
}

#[test]
fn well_conditioned_hits_are_where_double_precision_puts_them() {
    let mut random = Pcg::new(11);
    let (mut certain, mut missed) = (0, 0);
    for _ in 0..40 {
        let triangles: Vec<Triangle> = core::iter::repeat_with(|| {
            let center = random.in_cube() * 2.0;
            [(); 3].map(|()| (center + random.in_cube() * 0.5).as_vec3())
        })
        .filter(|[a, b, c]| (b - a).normalize().cross((c - a).normalize()).length() > 0.2)
        .take(200)
        .collect();
        let mut ray = || {
            let origin = (random.on_sphere() * 6.0).as_vec3();
            Ray::new(origin, (random.in_cube() * 2.0).as_vec3() - origin)
        };
        let rays: Vec<Ray> = (0..500).map(|_| ray()).collect();
        for (ray, hit) in rays.iter().zip(check(&triangles, &rays)) {
            let crossings: Vec<Crossing> = triangles.iter().map(|triangle| crossing(ray, triangle)).collect();
            if crossings.iter().any(Crossing::is_doubtful) {
                continue;
            }
            let found = (0..).zip(&crossings).filter(|(_, crossing)| crossing.is_hit());
            let mut hits: Vec<(f64, u32)> = found.map(|(prim_id, crossing)| (crossing.t, prim_id)).collect();
            hits.sort_by(|a, b| a.0.total_cmp(&b.0));
            match hits[..] {
                [] => {
                    missed += 1;
                    assert_eq!(hit, None);
                }
                [(first, _), (second, _), ..] if second - first < 1e-5 => {}
                [(t, prim_id), ..] => {
                    certain += 1;
                    let hit = hit.unwrap();
                    assert_eq!(hit.prim_id, prim_id);
                    assert!((f64::from(hit.t) - t).abs() < 1e-5 * t, "{hit:?} {t}");
                    let [a, b, c] = triangles[prim_id as usize];
                    let point = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
                    assert!((point - ray.at(hit.t)).length() < 1e-4, "{point} {}", ray.at(hit.t));
                }
            }
        }
    }
    assert!(certain > 5000 && missed > 1000, "{certain} {missed}");
}

/// Rays of the made terrain's camera that Embree 4.4 takes past these triangles, unless in its robust mode. Each passes
/// inside of one by a few 1e-5 of its size, which `f64` can tell, and Embree's robust test too.
#[test]
fn rays_close_to_an_edge_hit_the_triangle_that_they_are_in() {
    let origin = Vec3::new(20.947_403, 9.129_342, 28.245_676);
    let cases = [
        (
            Vec3::new(-0.616_640_1, -0.410_773_25, -0.671_580_6),
            [
                [6.484_43, -0.437_665_46, 12.5],
                [6.490_512_4, -0.470_483_78, 12.516_666],
                [6.528_782_4, -0.524_993_3, 12.516_666],
            ],
            23.420_881_8,
        ),
        (
            Vec3::new(-0.457_987_5, -0.431_026_13, -0.777_472_8),
            [
                [11.574_118, 0.314_014_35, 12.35],
                [11.595_963, 0.324_972_57, 12.366_667],
                [11.593_603, 0.319_833_43, 12.35],
            ],
            20.445_313_5,
        ),
    ];
    for (direction, triangle, t) in cases {
        let (ray, triangle) = (Ray::new(origin, direction), triangle.map(Vec3::from_array));
        let crossing = crossing(&ray, &triangle);
        assert!(1e-5 < crossing.least && crossing.least < 1e-4, "{}", crossing.least);
        assert!((crossing.t - t).abs() < 1e-6, "{}", crossing.t);
        let hit = check(&[triangle], &[ray])[0].expect("it is inside");
        assert!((f64::from(hit.t) - t).abs() < 4e-6, "{}", hit.t);
    }
}
