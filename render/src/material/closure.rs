//! The closure for a material's inputs: an enum of all kinds.

use glam::{Vec2, Vec3};

use super::{Bsdf, Evaluation, Glossy, Inputs, Kind, Layered, Matte, Sample, Transmissive};

/// A closure of any [`Kind`]. A loop over points of one kind is faster with the closure of that kind.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "closures live on the stack for one bounce")]
pub enum Closure {
    /// See [`Kind::Matte`].
    Matte(Matte),
    /// See [`Kind::Glossy`].
    Glossy(Glossy),
    /// See [`Kind::Transmissive`].
    Transmissive(Transmissive),
    /// See [`Kind::Layered`].
    Layered(Layered),
}

macro_rules! each {
    ($closure:expr, $inner:ident => $value:expr) => {
        match $closure {
            Closure::Matte($inner) => $value,
            Closure::Glossy($inner) => $value,
            Closure::Transmissive($inner) => $value,
            Closure::Layered($inner) => $value,
        }
    };
}

impl Closure {
    /// The closure of a kind, for inputs of that kind or a lesser one.
    #[inline]
    pub fn of_kind(kind: Kind, inputs: &Inputs, is_inside: bool) -> Self {
        match kind {
            Kind::Matte => Self::Matte(Bsdf::new(inputs, is_inside)),
            Kind::Glossy => Self::Glossy(Bsdf::new(inputs, is_inside)),
            Kind::Transmissive => Self::Transmissive(Bsdf::new(inputs, is_inside)),
            Kind::Layered => Self::Layered(Bsdf::new(inputs, is_inside)),
        }
    }
}

impl Closure {
    /// The part of [`eval`](Bsdf::eval)'s `f |cos θi|` that single microfacets reflect and refract: to compare with
    /// renderers that scatter the rest in another way, or not at all.
    pub fn eval_single(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.glossy(wo, wi)
    }
}

/// Closures that are made before it is known where they are needed.
pub(crate) trait Prepared: Bsdf + Copy {
    /// A closure that was made as one of this type's kind.
    fn of(closure: &Closure) -> &Self;

    /// One of the same kind for other inputs.
    fn with_inputs(&self, inputs: &Inputs, is_inside: bool) -> Self;

    /// The same for inputs that differ in the base colour alone from those that it was made from.
    #[inline]
    fn with_base_color(&self, inputs: &Inputs, is_inside: bool) -> Self {
        self.with_inputs(inputs, is_inside)
    }
}

impl Prepared for Closure {
    #[inline]
    fn of(closure: &Closure) -> &Self {
        closure
    }

    #[inline]
    fn with_inputs(&self, inputs: &Inputs, is_inside: bool) -> Self {
        let kind = match self {
            Self::Matte(_) => Kind::Matte,
            Self::Glossy(_) => Kind::Glossy,
            Self::Transmissive(_) => Kind::Transmissive,
            Self::Layered(_) => Kind::Layered,
        };
        Self::of_kind(kind, inputs, is_inside)
    }

    #[inline]
    fn with_base_color(&self, inputs: &Inputs, is_inside: bool) -> Self {
        match self {
            Self::Glossy(glossy) => Self::Glossy(glossy.with_base_color(inputs, is_inside)),
            _ => self.with_inputs(inputs, is_inside),
        }
    }
}

macro_rules! prepared {
    ($kind:ident $(, $with_base_color:item)?) => {
        impl Prepared for $kind {
            #[inline]
            fn of(closure: &Closure) -> &Self {
                match closure {
                    Closure::$kind(closure) => closure,
                    _ => unreachable!("paths are sorted by the kinds of their closures"),
                }
            }

            #[inline]
            fn with_inputs(&self, inputs: &Inputs, is_inside: bool) -> Self {
                Bsdf::new(inputs, is_inside)
            }

            $($with_base_color)?
        }
    };
}

prepared!(Transmissive);
prepared!(Layered);
prepared!(
    Glossy,
    #[inline]
    fn with_base_color(&self, inputs: &Inputs, _is_inside: bool) -> Self {
        let mut closure = *self;
        closure.set_base_color(inputs);
        closure
    }
);

impl Bsdf for Closure {
    #[inline]
    fn new(inputs: &Inputs, is_inside: bool) -> Self {
        Self::of_kind(Kind::of(inputs), inputs, is_inside)
    }

    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        each!(self, inner => inner.eval(wo, wi))
    }

    fn glossy(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        each!(self, inner => inner.glossy(wo, wi))
    }

    #[inline]
    fn sample(&self, wo: Vec3, u: Vec2) -> Option<Sample> {
        each!(self, inner => inner.sample(wo, u))
    }

    fn mirror_reflectance(&self, wo: Vec3) -> Vec3 {
        each!(self, inner => Bsdf::mirror_reflectance(inner, wo))
    }

    #[inline]
    fn albedo(&self, wo: Vec3) -> Vec3 {
        each!(self, inner => Bsdf::albedo(inner, wo))
    }

    #[inline]
    fn diffuse_albedo(&self, wo: Vec3) -> Vec3 {
        each!(self, inner => Bsdf::diffuse_albedo(inner, wo))
    }

    #[inline]
    fn transmits(&self) -> bool {
        each!(self, inner => Bsdf::transmits(inner))
    }
}
