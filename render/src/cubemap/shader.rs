//! The lookup that fits a cube map, as text for shaders.

use super::face::Axes;
use super::grid::Seams;
use super::lobe::{Filter, Mapping};
use super::{CubeMap, Options};
use crate::settings::named;

/// A shading language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// WebGPU's.
    Wgsl,
    /// OpenGL's and Vulkan's, from version 3.00 ES on.
    Glsl,
}

named!(Language: Wgsl = "wgsl", Glsl = "glsl");

/// Functions that look up a map: `cube_direction`, `cube_level`, `cube_seamless` and, with all of them, `cube_sample`.
pub fn lookup(map: &CubeMap, language: Language) -> String {
    let Options { size, seams, axes, filter, mapping, .. } = map.options;
    let last = map.levels.len() - 1;
    let flip = match axes {
        Axes::Bevy => ("v.x", "v.y", "-v.z"),
        Axes::Three => ("-v.x", "v.y", "v.z"),
        Axes::World => ("v.x", "v.y", "v.z"),
    };
    let flip = format!("{}, {}, {}", flip.0, flip.1, flip.2);
    let (measure, level) = match (filter, mapping) {
        (Filter::Ggx, Mapping::Linear) => ("roughness", format!("roughness * {last}.0")),
        (Filter::Ggx, Mapping::Sqrt) => ("roughness", format!("sqrt(roughness) * {last}.0")),
        (Filter::Phong, _) => ("power", format!("clamp({last}.0 - 0.5 * log2(power), 0.0, {last}.0)")),
    };
    let (v, f, vec3, let_) = match language {
        Language::Wgsl => ("vec3<f32>", "f32", "vec3<f32>", "let"),
        Language::Glsl => ("vec3", "float", "vec3", ""),
    };
    let function = |result: &str, name: &str, parameters: &[(&str, &str)], body: &str| match language {
        Language::Wgsl => {
            let parameters: Vec<_> = parameters.iter().map(|(name, kind)| format!("{name}: {kind}")).collect();
            format!("fn {name}({}) -> {result} {{\n{body}}}\n", parameters.join(", "))
        }
        Language::Glsl => {
            let parameters: Vec<_> = parameters.iter().map(|(name, kind)| format!("{kind} {name}")).collect();
            format!("{result} {name}({}) {{\n{body}}}\n", parameters.join(", "))
        }
    };
    let define = |kind: &str, name: &str, value: &str| match language {
        Language::Wgsl => format!("    {let_} {name} = {value};\n"),
        Language::Glsl => format!("    {kind} {name} = {value};\n"),
    };

    let mut text = format!(
        "// Looks up a cube map of {size} texels a side and {} levels, with seams treated by `{}`.\n\n",
        map.levels.len(),
        seams.name()
    );
    text += "// From world space to the cube map's own.\n";
    text += &function(v, "cube_direction", &[("v", v)], &format!("    return {vec3}({flip});\n"));
    text += &format!("\n// The level that is filtered by a {measure}.\n");
    text += &function(f, "cube_level", &[(measure, f)], &format!("    return {level};\n"));
    text += match seams {
        Seams::Lookup => {
            "\n// Shrinks all but the longest component, so that bilinear filtering meets the outermost texels.\n"
        }
        _ => "\n// Nothing is left to do for the lookup.\n",
    };
    let body = match (seams, language) {
        (Seams::Lookup, Language::Wgsl) => {
            define(v, "a", "abs(v)")
                + &define(f, "scale", &format!("1.0 - exp2(level) / {size}.0"))
                + "    return select(v * scale, v, a == vec3<f32>(max(a.x, max(a.y, a.z))));\n"
        }
        (Seams::Lookup, Language::Glsl) => {
            define(v, "a", "abs(v)")
                + &define(f, "scale", &format!("1.0 - exp2(level) / {size}.0"))
                + "    return mix(v * scale, v, vec3(equal(a, vec3(max(a.x, max(a.y, a.z))))));\n"
        }
        _ => "    return v;\n".to_owned(),
    };
    text += &function(v, "cube_seamless", &[("v", v), ("level", f)], &body);

    let sample = |level: &str| match language {
        Language::Wgsl => format!("textureSampleLevel(map, map_sampler, cube_seamless(d, {level}), {level}).rgb"),
        Language::Glsl => format!("textureLod(map, cube_seamless(d, {level}), {level}).rgb"),
    };
    let body = define(v, "d", "cube_direction(v)")
        + &define(f, "level", &format!("cube_level({measure})"))
        + &define(f, "low", "floor(level)")
        + &define(f, "high", &format!("min(low + 1.0, {last}.0)"))
        + &format!("    return mix({}, {}, level - low);\n", sample("low"), sample("high"));
    let texture: &[(&str, &str)] = match language {
        Language::Wgsl => &[("map", "texture_cube<f32>"), ("map_sampler", "sampler"), ("v", v), (measure, f)],
        Language::Glsl => &[("map", "samplerCube"), ("v", v), (measure, f)],
    };
    text += "\n// Prefiltered radiance from a direction of the world: each of two levels has its own scale.\n";
    text + &function(v, "cube_sample", texture, &body)
}
