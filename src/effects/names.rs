//! The effects by name.

/// An effect of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Name {
    /// Light that comes straight from emitters.
    Direct,
    /// Surfaces that stand in light's way.
    Occlusion,
    /// Light that surfaces reflect, any number of times.
    Interreflection,
    /// Bands that differ.
    Colour,
    /// Surfaces lit on both sides.
    TwoSided,
    /// A scene of segments in the plane.
    Flatland,
    /// Reflectance or emission that varies over a surface.
    Textures,
    /// Light from outside the scene.
    Environment,
    /// Lights without a surface: points, spots, suns.
    Lights,
    /// Surfaces that are not diffuse.
    Mirrors,
    /// Surfaces that light passes through, or that are cut out.
    Transparency,
    /// A medium that takes light away on its way.
    Medium,
}

impl Name {
    /// All of them, those that are built first.
    pub const ALL: [Name; 12] = [
        Name::Direct,
        Name::Occlusion,
        Name::Interreflection,
        Name::Colour,
        Name::TwoSided,
        Name::Flatland,
        Name::Textures,
        Name::Environment,
        Name::Lights,
        Name::Mirrors,
        Name::Transparency,
        Name::Medium,
    ];

    /// Its name in flags and reports.
    pub fn word(self) -> &'static str {
        match self {
            Name::Direct => "direct",
            Name::Occlusion => "occlusion",
            Name::Interreflection => "interreflection",
            Name::Colour => "colour",
            Name::TwoSided => "two-sided",
            Name::Flatland => "flatland",
            Name::Textures => "textures",
            Name::Environment => "environment",
            Name::Lights => "lights",
            Name::Mirrors => "mirrors",
            Name::Transparency => "transparency",
            Name::Medium => "medium",
        }
    }
}
