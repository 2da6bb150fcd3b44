//! Moments of a model's animations, and a summary of these.

/// A moment of a model's animations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// Seconds since the time 0 of the file.
    pub time: f64,
    /// The names of those to play; if there are none, all play that do not move the same things.
    pub animations: Vec<String>,
}

/// The name of an animation and the times of its motion.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Animation {
    /// The file's name for it, or its index.
    pub name: String,
    /// The time of its first key, in seconds.
    pub begin: f32,
    /// The time of its last key, in seconds.
    pub end: f32,
}
