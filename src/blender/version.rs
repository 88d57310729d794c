//! Versions of Blender: the oldest supported one and the tested ones.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// A version of Blender, ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Version {
    /// 4 in 4.5.15.
    pub major: u32,
    /// 5 in 4.5.15.
    pub minor: u32,
    /// 15 in 4.5.15.
    pub patch: u32,
}

impl Version {
    /// The oldest Blender that has every feature the scripts use.
    pub const OLDEST: Self = Self { major: 3, minor: 4, patch: 0 };

    /// The series on which the tests have passed.
    const TESTED: [(u32, u32); 3] = [(3, 4), (4, 5), (5, 0)];

    /// Whether the scripts can run on it.
    pub fn is_supported(self) -> bool {
        self >= Self::OLDEST
    }

    /// Whether the tests have passed on its series.
    pub fn is_tested(self) -> bool {
        Self::TESTED.contains(&(self.major, self.minor))
    }

    /// The tested series in words: `3.4, 4.5, 5.0`.
    pub fn tested_list() -> String {
        Self::TESTED.map(|(major, minor)| format!("{major}.{minor}")).join(", ")
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

impl FromStr for Version {
    type Err = String;

    /// Reads `3.4.1`, `4.5.15 LTS`, `2.79 (sub 0)`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("\"{text}\" is not a version of Blender");
        let numbers = text.split_whitespace().next().ok_or_else(wrong)?;
        let mut parts = numbers.split('.').map(|part| part.parse::<u32>().map_err(|_| wrong()));
        Ok(Self {
            major: parts.next().ok_or_else(wrong)??,
            minor: parts.next().ok_or_else(wrong)??,
            patch: parts.next().transpose()?.unwrap_or(0),
        })
    }
}

impl Serialize for Version {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Version {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::Version;

    fn version(text: &str) -> Version {
        text.parse().unwrap()
    }

    #[test]
    fn versions_are_read_as_blender_prints_them() {
        assert_eq!(version("4.5.15 LTS"), Version { major: 4, minor: 5, patch: 15 });
        assert_eq!(version("2.79 (sub 0)"), Version { major: 2, minor: 79, patch: 0 });
        for wrong in ["", "4", "four.five", "3.4.x"] {
            assert!(wrong.parse::<Version>().is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn versions_order_by_number_and_not_by_text() {
        assert!(version("3.10.0") > version("3.4.1"));
        assert!(!version("2.93.18").is_supported());
        assert!(version("3.4.0").is_supported() && version("5.1.0").is_supported());
        assert!(version("3.4.1").is_tested() && !version("3.6.0").is_tested());
    }
}
