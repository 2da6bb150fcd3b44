//! The manifest of a cube map's files for programs: JSON beside them.

use serde_json::{Value, json};

use super::face::Face;
use super::grid::Seams;
use super::lobe::{Filter, Lobe, Mapping};
use super::{CubeMap, Options, measure, unfold};

/// The version of the form; it changes when old readers would misunderstand a new manifest.
const VERSION: u32 = 1;

/// The manifest of a map that was written to these files, which are named from the manifest's folder.
pub fn manifest(map: &CubeMap, source: &str, files: &[String]) -> Value {
    let Options { size, seams, axes, filter, mapping, seed, .. } = map.options;
    let levels: Vec<Value> = (0..).zip(&map.levels).map(|(number, _)| level(map, number)).collect();
    let mapping = match (filter, mapping) {
        (Filter::Ggx, Mapping::Linear) => "roughness * (levels - 1)",
        (Filter::Ggx, Mapping::Sqrt) => "sqrt(roughness) * (levels - 1)",
        (Filter::Phong, _) => "levels - 1 - log2(power) / 2",
    };
    let lookup = if seams == Seams::Lookup { "1 - 2^level / size" } else { "1" };
    json!({
        "version": VERSION,
        "generator": concat!("halfdome ", env!("CARGO_PKG_VERSION")),
        "source": source,
        "unit": "W/(m² sr)",
        "size": size,
        "faces": Face::ALL.map(Face::name),
        "axes": axes.name(),
        "seams": seams.name(),
        "lookupScale": lookup,
        "filter": filter.name(),
        "level": mapping,
        "seed": seed,
        "levels": levels,
        "diffuse": map.diffuse.as_ref().map(|level| level.grid.size),
        "files": files,
    })
}

/// What a level is, where it stands in the unfolded picture, and its seams.
fn level(map: &CubeMap, number: u32) -> Value {
    let level = &map.levels[number as usize];
    let size = map.options.size;
    let place = |face: Face| {
        let unfold::Place { corner, turned } = unfold::place(size, number, face);
        (face.name().to_owned(), json!({ "corner": corner, "turned": turned }))
    };
    let smooth = Seams::ALL.into_iter().zip(measure::smooth(level.grid.size));
    let mut value = json!({
        "size": level.grid.size,
        "seam": measure::seam(level),
        "unfolded": Face::ALL.into_iter().map(place).collect::<serde_json::Map<_, _>>(),
        "smooth": smooth.map(|(seams, error)| (seams.name().to_owned(), json!(error))).collect::<serde_json::Map<_, _>>(),
    });
    match level.lobe {
        None => value["roughness"] = 0.into(),
        Some(Lobe::Ggx { roughness }) => value["roughness"] = roughness.into(),
        Some(Lobe::Phong { power }) => value["power"] = power.into(),
    }
    value
}
