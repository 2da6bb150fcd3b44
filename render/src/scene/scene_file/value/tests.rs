//! Values that both sources accept, and their errors.

use super::*;
use crate::scene::Daylight;

#[test]
fn names_may_look_like_numbers_and_lists() {
    let name = super::argument(super::text);
    for text in ["1", "2024.5", "true", "nan", "Cube, red", "Top"] {
        assert_eq!(name(text), Ok(text.to_owned()));
    }
}

#[test]
fn arguments_read_as_numbers_lists_or_text() {
    assert_eq!(Value::from_argument("18446744073709551615"), Value::Integer(u64::MAX.into()));
    assert_eq!(Value::from_argument("-0.5"), Value::Number(-0.5));
    assert_eq!(Value::from_argument("1, 2.5"), Value::List(vec![Value::Integer(1), Value::Number(2.5)]));
    assert_eq!(Value::from_argument("path"), Value::Text("path".into()));
}

#[test]
fn ranges_end_where_they_say() {
    assert!(argument(vfov)("0").is_err());
    assert!(argument(vfov)("180").is_err());
    assert!(argument(vfov)("nan").is_err());
    assert_eq!(argument(vfov)("179.5"), Ok(179.5));
    assert!(argument(side)("0").is_err());
    assert_eq!(argument(side)("65536"), Ok(65_536));
    assert!(argument(side)("65537").is_err());
    assert!(argument(side)("512.0").is_err());
    assert!(argument(count)("0").is_err());
    assert!(argument(count)("4294967296").is_err());
    assert_eq!(argument(seed)("18446744073709551615"), Ok(u64::MAX));
    assert!(argument(seed)("18446744073709551616").is_err());
    assert!(argument(seed)("-1").is_err());
    assert!(argument(filter_width)("0").is_err());
    assert_eq!(argument(filter_width)("64"), Ok(64.0));
    assert!(argument(filter_width)("64.1").is_err());
    assert!(argument(filter_width)("1e39").is_err(), "infinite as a 32-bit float");
    assert!(argument(sharpness)("1.01").is_err());
    assert!(argument(radiance)("1,-1,1").is_err());
    assert_eq!(argument(radiance)("0"), Ok(Vec3::ZERO));
    assert_eq!(argument(radiance)("1,2,3"), Ok(Vec3::new(1.0, 2.0, 3.0)));
    assert!(argument(radiance)("1,2").is_err());
    assert_eq!(argument(point)("-1,2,.5"), Ok(Vec3::new(-1.0, 2.0, 0.5)));
    assert!(argument(point)("1,2,inf").is_err());
    assert!(argument(point)("1,2,").is_err());
    assert!(argument(direction)("0,0,0").is_err());
    let day = |azimuth, turbidity| Ok(Daylight { elevation: 30.0, azimuth, turbidity });
    assert_eq!(argument(daylight)("30,-120"), day(-120.0, 3.0));
    assert_eq!(argument(daylight)("30,400,10"), day(400.0, 10.0));
    for wrong in ["30", "91,0", "-1,0", "30,0,1.6", "30,0,11", "30,0,3,4", "30,x"] {
        assert!(argument(daylight)(wrong).is_err(), "{wrong}");
    }
    assert!(argument(scale)("-1").is_err() && argument(degrees)("inf").is_err());
}

#[test]
fn misspelt_names_get_the_nearest() {
    let error = argument(integrator)("pth").unwrap_err();
    assert_eq!(
        error.to_string(),
        "expected one of path, cached, montecarlo, direct, ao, flat, heat, heat-lights, normals, albedo; did you mean `path`?"
    );
    let error = argument(filter)("bx").unwrap_err();
    assert_eq!(error.to_string(), "expected one of box, tent, gaussian, mitchell; did you mean `box`?");
    assert_eq!(argument(emission)("back").unwrap_err().to_string(), "expected one of front, both");
}
