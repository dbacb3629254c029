//! Confusion matrix and accuracies.

use serde::{Deserialize, Serialize};

/// Counts of true against predicted classes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Confusion {
    /// Class names, in the order of rows and columns.
    pub labels: Vec<String>,
    /// `counts[truth][prediction]`
    pub counts: Vec<Vec<u32>>,
}

impl Confusion {
    /// A matrix of zeros.
    pub fn new(labels: &[String]) -> Self {
        Self {
            labels: labels.to_vec(),
            counts: vec![vec![0; labels.len()]; labels.len()],
        }
    }

    /// Counts one answer, by class indices.
    pub fn add(&mut self, truth: usize, prediction: usize) {
        self.counts[truth][prediction] += 1;
    }

    /// Share of right answers; 0 without answers.
    pub fn accuracy(&self) -> f64 {
        let right: u32 = (0..self.labels.len())
            .map(|class| self.counts[class][class])
            .sum();
        share(right, self.counts.iter().flatten().sum())
    }

    /// Share of right answers within each true class.
    pub fn class_accuracies(&self) -> Vec<f64> {
        let rows = self.counts.iter().enumerate();
        rows.map(|(class, row)| share(row[class], row.iter().sum()))
            .collect()
    }

    /// A table for people: a row a true class, a column a predicted one.
    pub fn table(&self) -> String {
        let width = self.labels.iter().map(String::len).max().unwrap_or(0);
        let mut table = String::new();
        for ((label, row), accuracy) in self
            .labels
            .iter()
            .zip(&self.counts)
            .zip(self.class_accuracies())
        {
            let cells: String = row.iter().map(|count| format!("{count:6}")).collect();
            table += &format!("{label:width$}{cells}  {:5.1} %\n", 100.0 * accuracy);
        }
        table
    }
}

fn share(part: u32, whole: u32) -> f64 {
    if whole == 0 {
        0.0
    } else {
        f64::from(part) / f64::from(whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accuracies_count_the_diagonal() {
        let mut confusion = Confusion::new(&["a".to_owned(), "b".to_owned()]);
        for (truth, prediction) in [(0, 0), (0, 0), (0, 1), (1, 1)] {
            confusion.add(truth, prediction);
        }
        assert_eq!(confusion.accuracy(), 0.75);
        assert_eq!(confusion.class_accuracies(), [2.0 / 3.0, 1.0]);
        assert!(confusion.table().starts_with("a     2     1   66.7 %"));
        assert_eq!(Confusion::new(&["a".to_owned()]).accuracy(), 0.0);
    }
}
