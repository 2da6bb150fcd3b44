//! The files of a cube map, each replaced atomically, the manifest last.

use std::path::{Path, PathBuf};

use crate::cli::error::{CliError, invalid};
use crate::cubemap::{self, CubeMap, Face, Language, Level, unfold};
use crate::output::{Map, OutputFile, Shape, Texture, ToneMapping, encode_exr, encode_hdr, encode_ktx2_texture, write};
use crate::scene::count;

/// The output paths.
pub(super) struct Files {
    outputs: Vec<(PathBuf, Format)>,
    lookup: Option<(PathBuf, Language)>,
    manifest: PathBuf,
    tone: ToneMapping,
}

/// The storage of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Ktx2,
    Exr,
    Png,
    Hdr,
}

/// The files that were written, and texels that had to be changed for them.
#[derive(Default)]
struct Written {
    paths: Vec<PathBuf>,
    warnings: Vec<String>,
}

impl Files {
    /// Checks that everything can be written.
    pub(super) fn new(outputs: &[PathBuf], lookup: Option<Language>, tone: ToneMapping) -> Result<Self, CliError> {
        let format = |path: &PathBuf| {
            let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
            let format = match extension.as_str() {
                "ktx2" => Format::Ktx2,
                "exr" => Format::Exr,
                "png" => Format::Png,
                "hdr" => Format::Hdr,
                _ => {
                    let problem = format!("{}: cube maps cannot be written in this format", path.display());
                    return Err(invalid(problem, "give a name that ends in .ktx2, .exr, .png or .hdr"));
                }
            };
            OutputFile::check(path).map_err(CliError::input)?;
            Ok((path.clone(), format))
        };
        for (i, path) in outputs.iter().enumerate() {
            if outputs[..i].contains(path) {
                let problem = format!("{} is given twice", path.display());
                return Err(invalid(problem, "give each file its own name"));
            }
        }
        let outputs = outputs.iter().map(format).collect::<Result<Vec<_>, _>>()?;
        let Some((first, _)) = outputs.first() else { return Err(invalid("no file is named", "give --output FILE")) };
        let (manifest, lookup) =
            (first.with_extension("json"), lookup.map(|language| (first.with_extension(language.name()), language)));
        for path in [Some(&manifest), lookup.as_ref().map(|(path, _)| path)].into_iter().flatten() {
            OutputFile::check(path).map_err(CliError::input)?;
        }
        Ok(Self { outputs, lookup, manifest, tone })
    }

    /// All that is written.
    pub(super) fn paths(&self) -> Vec<&Path> {
        let lookup = self.lookup.iter().map(|(path, _)| path.as_path());
        self.outputs.iter().map(|(path, _)| path.as_path()).chain([self.manifest.as_path()]).chain(lookup).collect()
    }

    /// Writes everything; gives the paths and warnings.
    pub(super) fn write(&self, map: &CubeMap, source: &str) -> Result<(Vec<PathBuf>, Vec<String>), CliError> {
        let mut written = Written::default();
        for (path, format) in &self.outputs {
            self.write_levels(path, *format, &map.levels, &mut written)?;
            if let Some(level) = &map.diffuse {
                self.write_levels(&with_suffix(path, "-diffuse"), *format, std::slice::from_ref(level), &mut written)?;
            }
        }
        if let Some((path, language)) = &self.lookup {
            written.bytes(path.clone(), cubemap::lookup(map, *language).as_bytes())?;
        }
        let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let names: Vec<String> = written.paths.iter().map(name).collect();
        let manifest = format!("{:#}\n", cubemap::manifest(map, source, &names));
        written.bytes(self.manifest.clone(), manifest.as_bytes())?;
        Ok((written.paths, written.warnings))
    }

    fn write_levels(
        &self,
        path: &Path,
        format: Format,
        levels: &[Level],
        written: &mut Written,
    ) -> Result<(), CliError> {
        match format {
            Format::Ktx2 => {
                let levels: Vec<_> = levels.iter().map(|level| (level.grid.size, level.texels.as_slice())).collect();
                let texture = Texture {
                    shape: Shape::Cube(levels[0].0),
                    levels: levels.iter().map(|(_, texels)| *texels).collect(),
                    is_signed: false,
                };
                let file = encode_ktx2_texture(path, &texture).map_err(CliError::system)?;
                written.clamped(path, file.clamped);
                written.bytes(path.to_owned(), &file.bytes)
            }
            Format::Exr => {
                let bytes = encode_exr(path, &unfold::unfold(levels)).map_err(CliError::system)?;
                written.bytes(path.to_owned(), &bytes)
            }
            Format::Png => {
                write(path, &unfold::show(levels), &self.tone).map_err(CliError::system)?;
                written.paths.push(path.to_owned());
                Ok(())
            }
            Format::Hdr => {
                for (number, level) in levels.iter().enumerate() {
                    for face in Face::ALL {
                        let size = level.grid.size;
                        let number = if number == 0 { String::new() } else { format!("-{number}") };
                        let path = with_suffix(path, &format!("-{}{number}", face.name()));
                        let map = Map { width: size, height: size, texels: level.face(face) };
                        let file = encode_hdr(&path, &map).map_err(CliError::system)?;
                        written.clamped(&path, file.clamped);
                        written.bytes(path, &file.bytes)?;
                    }
                }
                Ok(())
            }
        }
    }
}

impl Written {
    fn bytes(&mut self, path: PathBuf, bytes: &[u8]) -> Result<(), CliError> {
        OutputFile::check(&path).and_then(|file| file.write(bytes)).map_err(CliError::system)?;
        self.paths.push(path);
        Ok(())
    }

    fn clamped(&mut self, path: &Path, texels: usize) {
        if texels > 0 {
            let texels = count(texels, "texel is", "texels are");
            let text = format!("{}: {texels} brighter than the format can store, clamped", path.display());
            self.warnings.push(text);
        }
    }
}

/// The path with something between its name and its extension.
fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let [stem, extension] = [path.file_stem(), path.extension()].map(|part| part.unwrap_or_default().to_string_lossy());
    path.with_file_name(format!("{stem}{suffix}.{extension}"))
}
