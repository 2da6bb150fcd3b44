//! Declaration of options: once for the command line, for scene files, and for their combination.

use super::super::value::{Expected, Value};

/// A value in a scene file.
pub(crate) trait Source {
    type Error;

    /// The value, as `reading` reads it.
    ///
    /// # Errors
    /// If it expects another one.
    fn read<T>(&self, reading: fn(&Value) -> Result<T, Expected>) -> Result<T, Self::Error>;
}

/// Fallback of options and groups of them: a method of each.
pub(super) trait Or {
    fn or(self, fallback: Self) -> Self;
}

/// Declares a group of options. In `options` each has a type, and how a text or a value of TOML is read as one; its
/// name is that of the field, and so is its key in the section of scene files that `in` names, unless another follows.
/// `others` are what is read in a way of its own, and groups in this group.
macro_rules! options {
    (
        $(#[$meta:meta])*
        pub struct $name:ident;
        options {$(
            $(#[$option_meta:meta])*
            $option:ident: $type:ty = $reading:path, in $section:literal $($key:literal)?;
        )*}
        others {$(
            $(#[$other_meta:meta])*
            $other:ident: $other_type:ty $(, in $other_section:literal $($other_key:literal)?)?;
        )*}
    ) => {
        #[derive(clap::Args, Clone, Debug, Default, PartialEq)]
        $(#[$meta])*
        pub struct $name {
            $(
                $(#[$option_meta])*
                #[arg(long, value_parser = $crate::scene::scene_file::value::argument($reading))]
                pub $option: Option<$type>,
            )*
            $(
                $(#[$other_meta])*
                pub $other: $other_type,
            )*
        }

        #[allow(dead_code, reason = "each group needs some of these")]
        impl $name {
            /// The names of their fields.
            pub(crate) const NAMES: &'static [&'static str] = &[$(stringify!($option)),*];

            /// The sections of scene files and the keys in them.
            pub(crate) const KEYS: &'static [(&'static str, &'static str)] = &[
                $(($section, options!(@key $option $($key)?)),)*
                $($(($other_section, options!(@key $other $($other_key)?)),)?)*
            ];

            /// The names of the options, and whether they are set.
            pub(super) fn given(&self) -> impl Iterator<Item = (&'static str, bool)> + use<> {
                [
                    $((stringify!($option), self.$option.is_some()),)*
                    $($((options!(@of $other_section stringify!($other)), self.$other.is_some()),)?)*
                ]
                .into_iter()
            }

            /// Without the options that are not among `names`.
            pub(super) fn only(mut self, names: &[&str]) -> Self {
                $(if !names.contains(&stringify!($option)) {
                    self.$option = None;
                })*
                $($(if !names.contains(&options!(@of $other_section stringify!($other))) {
                    self.$other = None;
                })?)*
                self
            }

            /// These options, and those of `fallback` where these are not set.
            pub(super) fn or_each(self, fallback: Self) -> Self {
                Self {
                    $($option: self.$option.or(fallback.$option),)*
                    $($other: self.$other.or(fallback.$other),)*
                }
            }

            /// Sets this group's option of a scene file's key; returns whether there is one.
            pub(crate) fn set<S: $crate::scene::scene_file::overrides::options::Source>(
                &mut self,
                section: &str,
                key: &str,
                source: &S,
            ) -> Result<bool, S::Error> {
                $(if (section, key) == ($section, options!(@key $option $($key)?)) {
                    self.$option = Some(source.read($reading)?);
                    return Ok(true);
                })*
                Ok(false)
            }
        }
    };
    // Of those among `others` that have a key.
    (@of $section:literal $value:expr) => { $value };
    (@key $option:ident) => { stringify!($option) };
    (@key $option:ident $key:literal) => { $key };
}
pub(super) use options;
