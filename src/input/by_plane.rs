//! One number for both planes, or one for each.

use schemars::JsonSchema;
use serde::Deserialize;

/// One number for both planes, or one for each.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum ByPlane {
    Both(f64),
    Each(EachPlane),
}

/// Numbers by plane; zero where none is given.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct EachPlane {
    /// In x.
    #[serde(default)]
    x: f64,
    /// In y.
    #[serde(default)]
    y: f64,
}

impl Default for ByPlane {
    fn default() -> Self {
        Self::Both(0.0)
    }
}

impl ByPlane {
    pub(super) fn is_by_plane(self) -> bool {
        matches!(self, Self::Each(_))
    }

    /// In x and in y.
    pub(super) fn pair(self) -> [f64; 2] {
        match self {
            Self::Both(value) => [value; 2],
            Self::Each(EachPlane { x, y }) => [x, y],
        }
    }

    /// Half the sum, which is the number itself where there is one.
    pub(super) fn mean(self) -> f64 {
        let [x, y] = self.pair();
        0.5 * (x + y)
    }
}
