//! Constants of the laws for rubber, and the moduli that follow from them.

use crate::materials::{Law, Material};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Up to three numbers of a law; those that are not given are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct Constants(pub [f64; 3]);

impl Constants {
    /// Whether there are none.
    pub fn are_none(&self) -> bool {
        self.count() == 0
    }

    /// How many there are: up to the last that is not zero.
    pub fn count(&self) -> usize {
        self.0.iter().rposition(|c| *c != 0.0).map_or(0, |last| last + 1)
    }
}

impl From<Constants> for Vec<f64> {
    fn from(constants: Constants) -> Self {
        constants.0[..constants.count()].to_vec()
    }
}

impl TryFrom<Vec<f64>> for Constants {
    type Error = String;

    fn try_from(given: Vec<f64>) -> Result<Self, String> {
        let mut constants = Self::default();
        if given.len() > constants.0.len() {
            let most = constants.0.len();
            return Err(format!("constants and exponents are at most {most} each, not {}", given.len()));
        }
        constants.0[..given.len()].copy_from_slice(&given);
        Ok(constants)
    }
}

impl Law {
    /// Whether it is given by constants, from which Young's modulus follows.
    pub fn has_constants(self) -> bool {
        matches!(self, Self::MooneyRivlin | Self::Yeoh | Self::Ogden)
    }
}

impl Material {
    /// Young's modulus (Pa) at small strain of a law that has it from constants.
    pub fn modulus_of_constants(&self) -> Option<f64> {
        let c = &self.constants.0;
        let mu = match self.law {
            Law::AlmansiHooke | Law::StVenantKirchhoff | Law::NeoHookean => return None,
            Law::MooneyRivlin => 2.0 * (c[0] + c[1]),
            Law::Yeoh => 2.0 * c[0],
            Law::Ogden => 0.5 * c.iter().zip(&self.exponents.0).map(|(mu, alpha)| mu * alpha).sum::<f64>(),
        };
        Some(2.0 * (1.0 + self.poisson_ratio) * mu)
    }

    /// `C₁₀`, `C₀₁`, `C₂₀`, `C₃₀` (Pa), or Ogden's constants.
    pub(crate) fn polynomial(&self) -> [f64; 4] {
        let [a, b, c] = self.constants.0;
        if self.law == Law::Yeoh { [a, 0.0, b, c] } else { [a, b, c, 0.0] }
    }

    /// What is wrong with the constants of the law: key, problem and remedy.
    pub fn wrong_constants(&self) -> Option<(&'static str, String, &'static str)> {
        let (count, exponents) = (self.constants.count(), self.exponents.count());
        let wanted = match self.law {
            Law::AlmansiHooke | Law::StVenantKirchhoff | Law::NeoHookean => 0..=0,
            Law::MooneyRivlin => 1..=2,
            Law::Yeoh | Law::Ogden => 1..=3,
        };
        let all = self.constants.0.iter().chain(&self.exponents.0);
        if !wanted.contains(&count) || !all.clone().all(|c| c.is_finite()) {
            let problem = match count {
                0 => "has no constants".to_owned(),
                _ if *wanted.end() == 0 => "belongs to another law".to_owned(),
                _ => format!("has {count} numbers"),
            };
            let remedy = "mooney-rivlin takes C10 and C01, yeoh C10, C20 and C30, ogden up to three, in Pa";
            return Some(("constants", problem, remedy));
        }
        let paired = if self.law == Law::Ogden { count } else { 0 };
        if exponents != paired {
            let remedy = "ogden takes one for each of the constants, the other laws none";
            return Some(("exponents", format!("has {exponents} numbers for {paired} terms"), remedy));
        }
        if self.modulus_of_constants().is_some_and(|modulus| modulus <= 0.0) {
            let remedy = "take C10 + C01, C10, or the sum of mu_p alpha_p over zero";
            return Some(("constants", "make no stiffness at small strain".to_owned(), remedy));
        }
        None
    }
}
