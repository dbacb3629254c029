//! How much a cloud is like what was kept of the known objects: Mahalanobis distance in the space of the pooled features.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::kept::{Block, FeatureRows};

/// Shrinkage of each class's covariance towards the mean covariance of all classes: the latter weighs as much as this number
/// of clouds. A covariance of few clouds alone would be singular.
const COMMON_CLOUDS: f64 = 50.0;
/// Ridge regularisation: this share of the mean variance is added to the diagonal of each covariance. Without it, a feature with
/// (almost) no variance would dominate the Mahalanobis distance.
const RIDGE: f64 = 1e-3;

/// Out-of-distribution detector: one Gaussian distribution of the pooled features for each known class (Lee et al. 2018, "A
/// simple unified framework for detecting out-of-distribution samples"; they share one covariance among all classes, here each class
/// has its own). The network's own energy score is reliable only for the classes that the network was trained on.
#[derive(Debug, Clone, PartialEq)]
pub struct Familiar {
    classes: Vec<Normal>,
}

#[derive(Debug, Clone, PartialEq)]
struct Normal {
    mean: DVector<f64>,
    /// The inverse of the covariance's Cholesky factor, lower triangular.
    whitening: DMatrix<f64>,
}

impl Familiar {
    /// Of the features of each known object. `None` where there are none, or they are not finite.
    pub fn of<'a>(known: impl IntoIterator<Item = &'a FeatureRows>) -> Option<Self> {
        let known: Vec<&FeatureRows> = known.into_iter().collect();
        let spreads: Vec<(DVector<f64>, DMatrix<f64>)> = known
            .iter()
            .map(|rows| spread(rows))
            .collect::<Option<_>>()?;
        let width = known.first()?.width();
        let mut common = DMatrix::zeros(width, width);
        for (_, covariance) in &spreads {
            common += covariance / spreads.len() as f64;
        }
        let ridge = RIDGE * common.trace() / width as f64 + f64::MIN_POSITIVE;
        let classes = spreads.into_iter().zip(&known);
        let classes = classes.map(|((mean, covariance), rows)| {
            let share = COMMON_CLOUDS / (COMMON_CLOUDS + rows.len() as f64);
            let mut covariance = (1.0 - share) * covariance + share * &common;
            for index in 0..width {
                covariance[(index, index)] += ridge;
            }
            let root = Cholesky::new(covariance)?.unpack();
            let whitening = root.solve_lower_triangular(&DMatrix::identity(width, width))?;
            Some(Normal { mean, whitening })
        });
        Some(Self {
            classes: classes.collect::<Option<_>>()?,
        })
    }

    /// Of the known objects among these blocks, by the clouds that layers are fitted with.
    pub fn of_known(blocks: &[Block]) -> Option<Self> {
        let known = blocks.iter().filter(|block| block.label.is_some());
        Self::of(known.map(|block| &block.fit))
    }

    /// Minus the distance of each row to the nearest class, in standard deviations; larger is more alike.
    ///
    /// # Panics
    /// If the rows have another number of features.
    pub fn scores(&self, rows: &FeatureRows) -> Vec<f64> {
        let values = rows.matrix().transpose();
        let mut squares = vec![f64::INFINITY; rows.len()];
        for class in &self.classes {
            let mut off = values.clone();
            off.column_iter_mut()
                .for_each(|mut column| column -= &class.mean);
            let off = &class.whitening * off;
            for (square, column) in squares.iter_mut().zip(off.column_iter()) {
                *square = square.min(column.norm_squared());
            }
        }
        squares.into_iter().map(|square| -square.sqrt()).collect()
    }

    /// The mean of the rows' scores, for a cloud of several samples; minus infinity without rows.
    ///
    /// # Panics
    /// As [`Familiar::scores`].
    pub fn score(&self, rows: &FeatureRows) -> f64 {
        if rows.is_empty() {
            return f64::NEG_INFINITY;
        }
        self.scores(rows).iter().sum::<f64>() / rows.len() as f64
    }
}

/// Mean and covariance.
fn spread(rows: &FeatureRows) -> Option<(DVector<f64>, DMatrix<f64>)> {
    if rows.is_empty() {
        return None;
    }
    let mut values = rows.matrix();
    let mean = values.row_mean();
    values.row_iter_mut().for_each(|mut row| row -= &mean);
    let covariance = values.tr_mul(&values) / rows.len() as f64;
    covariance
        .iter()
        .all(|value| value.is_finite())
        .then(|| (mean.transpose(), covariance))
}
