//! The effects of directives.

use std::path::Path;
use std::rc::Rc;

use glam::{DAffine3, DVec3};

use super::arguments::{numbers, skip, string};
use super::parameters::Parameters;
use super::state::{Saved, State, look_at, matrix};
use super::tokens::{At, Kind, Tokens};
use super::{Reader, of_v3};
use crate::scene::SceneError;
use crate::scene::nearest::nearest;

/// Known directives, to suggest for misspelt ones.
const KNOWN: [&str; 36] = [
    "Accelerator",
    "ActiveTransform",
    "AreaLightSource",
    "Attribute",
    "AttributeBegin",
    "AttributeEnd",
    "Camera",
    "ColorSpace",
    "ConcatTransform",
    "CoordSysTransform",
    "CoordinateSystem",
    "Film",
    "Identity",
    "Import",
    "Include",
    "Integrator",
    "LightSource",
    "LookAt",
    "MakeNamedMaterial",
    "MakeNamedMedium",
    "Material",
    "MediumInterface",
    "NamedMaterial",
    "ObjectBegin",
    "ObjectEnd",
    "ObjectInstance",
    "Option",
    "PixelFilter",
    "ReverseOrientation",
    "Rotate",
    "Sampler",
    "Scale",
    "Shape",
    "Texture",
    "Transform",
    "Translate",
];

impl Reader<'_> {
    /// Does what a file says.
    pub(super) fn run(&mut self, path: Rc<Path>, text: &[u8]) -> Result<(), SceneError> {
        self.open.push(path.clone());
        let mut tokens = Tokens::new(path, text);
        while let Some(token) = tokens.next()? {
            let at = tokens.at(token.line);
            if token.kind != Kind::Word {
                let problem = format!("{} stands where a directive should", token.shown());
                return Err(at.error(problem, "begin with a directive such as `Shape` or `Translate`"));
            }
            self.directive(token.raw(), at, &mut tokens)?;
        }
        self.open.pop();
        Ok(())
    }

    fn directive(&mut self, name: &str, at: At, tokens: &mut Tokens) -> Result<(), SceneError> {
        match name {
            "Identity" => self.state.replace(DAffine3::IDENTITY, &at)?,
            "Translate" => {
                let by = DVec3::from_array(numbers(name, &at, tokens)?);
                self.state.concat(DAffine3::from_translation(by), &at)?;
            }
            "Scale" => {
                let by = DVec3::from_array(numbers(name, &at, tokens)?);
                self.state.concat(DAffine3::from_scale(by), &at)?;
            }
            "Rotate" => {
                let [degrees, x, y, z] = numbers(name, &at, tokens)?;
                let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
                    return Err(at.error("the axis of `Rotate` is zero", "write an angle in degrees and an axis"));
                };
                self.state.concat(DAffine3::from_axis_angle(axis, degrees.to_radians()), &at)?;
            }
            "LookAt" => {
                let it: [f64; 9] = numbers(name, &at, tokens)?;
                let vectors = [0, 3, 6].map(|first| DVec3::from_slice(&it[first..first + 3]));
                self.state.concat(look_at(vectors, &at)?, &at)?;
            }
            "Transform" => {
                let transform = matrix(numbers(name, &at, tokens)?, &at)?;
                self.state.replace(transform, &at)?;
            }
            "ConcatTransform" => {
                let transform = matrix(numbers(name, &at, tokens)?, &at)?;
                self.state.concat(transform, &at)?;
            }
            "CoordinateSystem" => {
                let system = string(name, &at, tokens)?;
                self.systems.insert(system, self.state.transform);
            }
            "CoordSysTransform" => {
                let system = string(name, &at, tokens)?;
                match self.systems.get(&system) {
                    Some(&transform) => self.state.replace(transform, &at)?,
                    None => {
                        let problem = format!("there is no coordinate system {system:?}");
                        let remedy = format!("define it before: `CoordinateSystem {system:?}`");
                        return Err(at.error(problem, remedy));
                    }
                }
            }
            "ActiveTransform" => {
                let which = tokens.next()?.map_or_else(String::new, |token| token.text());
                self.state.is_at_start = which != "EndTime";
                self.note(
                    &at,
                    "motion (`ActiveTransform`) is not read: things are where they are as the shutter opens",
                );
            }
            "TransformTimes" => drop(numbers::<2>(name, &at, tokens)?),
            "ReverseOrientation" => self.state.reverses = !self.state.reverses,
            "WorldBegin" => {
                // Defaults that `Attribute` set before hold on, as in pbrt.
                (self.state.transform, self.state.is_at_start) = (DAffine3::IDENTITY, true);
                self.systems.insert("world".to_owned(), DAffine3::IDENTITY);
            }
            "AttributeBegin" => self.begin("Attribute", at),
            "TransformBegin" => self.begin("Transform", at),
            "AttributeEnd" => drop(self.end("Attribute", &at)?),
            "TransformEnd" => {
                // Only the transform is as before.
                let before = self.end("Transform", &at)?;
                self.state = State { transform: self.state.transform, is_at_start: self.state.is_at_start, ..before };
            }
            "ObjectBegin" => {
                let object = string(name, &at, tokens)?;
                self.begin_object(object, &at)?;
                self.begin("Object", at);
            }
            "ObjectEnd" => {
                self.end("Object", &at)?;
                self.objects.current = None;
            }
            "ObjectInstance" => {
                let object = string(name, &at, tokens)?;
                self.instance(object, at)?;
            }
            "Include" | "Import" => self.include(name, at, tokens)?,
            _ => self.directive_with_parameters(name, at, tokens)?,
        }
        Ok(())
    }

    fn directive_with_parameters(&mut self, name: &str, at: At, tokens: &mut Tokens) -> Result<(), SceneError> {
        match name {
            "Attribute" => {
                let target = string(name, &at, tokens)?;
                let parameters = Parameters::read(format!("Attribute {target:?}"), at, tokens)?;
                let defaults = Rc::make_mut(&mut self.state.defaults);
                defaults.extend(parameters.into_list().into_iter().map(|parameter| (target.clone(), parameter)));
            }
            "Material" => {
                let (kind, parameters) = self.typed(name, "material", at, tokens)?;
                self.set_material(&kind, &parameters)?;
            }
            "MakeNamedMaterial" => {
                let (material, parameters) = self.typed(name, "material", at, tokens)?;
                self.name_material(material, &parameters)?;
            }
            "NamedMaterial" => {
                let material = string(name, &at, tokens)?;
                self.state.material = Some(self.named_material(material, &at));
            }
            "Texture" => {
                let texture = string(name, &at, tokens)?;
                let kind = string(name, &at, tokens)?;
                let (class, parameters) = self.typed(name, "texture", at, tokens)?;
                self.define_texture(texture, &kind, &class, &parameters)?;
            }
            "Shape" => {
                let (kind, parameters) = self.typed(name, "shape", at, tokens)?;
                self.shape(&kind, &parameters)?;
            }
            "LightSource" => {
                let (kind, parameters) = self.typed(name, "light", at, tokens)?;
                self.light(&kind, &parameters)?;
                self.warn_of_unused(&parameters);
            }
            "AreaLightSource" => {
                let (kind, parameters) = self.typed(name, "light", at, tokens)?;
                self.state.light = Some(self.area_light(&kind, &parameters)?);
                self.warn_of_unused(&parameters);
            }
            "Camera" => {
                let (kind, parameters) = self.typed(name, "", at, tokens)?;
                self.camera(&kind, &parameters)?;
            }
            "Film" => {
                let (kind, parameters) = self.typed(name, "", at, tokens)?;
                self.film(&kind, &parameters)?;
            }
            "Sampler" => {
                let (kind, parameters) = self.typed(name, "", at, tokens)?;
                self.sampler(&kind, &parameters)?;
            }
            // Options of a render, which are the command line's here.
            "Integrator" | "PixelFilter" => {
                let (kind, Parameters { at, .. }) = self.typed(name, "", at, tokens)?;
                let option = if name == "Integrator" { "--integrator" } else { "--filter" };
                self.note(&at, &format!("`{name} {kind:?}` is not read; `{option}` sets it"));
            }
            "Accelerator" => drop(self.typed(name, "", at, tokens)?),
            "Option" => drop(Parameters::read(name.to_owned(), at, tokens)?),
            "ColorSpace" => {
                let space = string(name, &at, tokens)?;
                if space != "srgb" {
                    self.note(&at, &format!("the colour space {space:?} is not read; colours are taken as sRGB"));
                }
            }
            "MakeNamedMedium" | "MediumInterface" => {
                string(name, &at, tokens)?;
                skip(tokens)?;
                self.note(&at, "media are not read");
            }
            "WorldEnd" | "SurfaceIntegrator" | "VolumeIntegrator" | "Renderer" | "Volume" => {
                return Err(of_v3(&at, &format!("the directive `{name}`")));
            }
            _ => {
                if !name.starts_with(|first: char| first.is_ascii_alphabetic()) {
                    let problem = format!("`{name}` stands where a directive should");
                    return Err(at.error(problem, "begin with a directive such as `Shape` or `Translate`"));
                }
                skip(tokens)?;
                let hint = nearest(name, &KNOWN).map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default();
                self.note(&at, &format!("the directive `{name}` is not known and left out{hint}"));
            }
        }
        Ok(())
    }

    /// The type and the parameters of a directive, with the defaults that `Attribute` set for such as `target`.
    fn typed(&self, name: &str, target: &str, at: At, tokens: &mut Tokens) -> Result<(String, Parameters), SceneError> {
        let kind = string(name, &at, tokens)?;
        let mut parameters = Parameters::read(format!("{name} {kind:?}"), at, tokens)?;
        for (of, default) in self.state.defaults.iter().rev() {
            if of == target {
                parameters.add_default(default);
            }
        }
        Ok((kind, parameters))
    }

    fn begin(&mut self, what: &'static str, at: At) {
        self.saved.push(Saved { what, at, state: self.state.clone() });
    }

    /// Brings back the state of before; gives that of until now.
    fn end(&mut self, what: &'static str, at: &At) -> Result<State, SceneError> {
        let remedy = format!("begin it with `{what}Begin`, and end what begins in it before");
        match self.saved.pop() {
            Some(saved) if saved.what == what => Ok(std::mem::replace(&mut self.state, saved.state)),
            Some(saved) => {
                let problem = format!("`{what}End` ends a `{}Begin`, of line {}", saved.what, saved.at.line);
                Err(at.error(problem, remedy))
            }
            None => Err(at.error(format!("`{what}End` has no `{what}Begin`"), remedy)),
        }
    }

    /// `Include`, and `Import`, which leaves the state as it was.
    fn include(&mut self, name: &str, at: At, tokens: &mut Tokens) -> Result<(), SceneError> {
        let file = string(name, &at, tokens)?;
        let path: Rc<Path> = self.resolve(&file, &at).into();
        if self.open.contains(&path) {
            let chain: Vec<String> = self.open.iter().chain([&path]).map(|it| it.display().to_string()).collect();
            let problem = format!("{file:?} includes itself: {}", chain.join(" > "));
            return Err(at.error(problem, "remove one of these includes"));
        }
        let text = self.read_file(&path, &at)?;
        let (before, depth) = (self.state.clone(), self.saved.len());
        self.run(path, &text)?;
        if name == "Import" {
            if self.saved.len() > depth {
                let Saved { what, at, .. } = &self.saved[depth];
                return Err(
                    at.error(format!("`{what}Begin` has no `{what}End`"), "end it in the file that is imported")
                );
            }
            self.state = before;
        }
        Ok(())
    }
}
