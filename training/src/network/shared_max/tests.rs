#![allow(clippy::unwrap_used)]
use candle_core::Device;

use super::super::testing::{largest_difference, random};
use super::*;

#[test]
fn values_and_gradients_are_those_of_candles_own_operations() {
    for columns in [3, 6] {
        let (x, first, second) = (
            random((4, 7, columns)),
            random((columns + 1, 11)),
            random((12, 9)),
        );
        let fused = shared_max(&x, &first, &second).unwrap();
        let plain = plain(&x, &first, &second).unwrap();
        assert!(largest_difference(&fused, &plain) < 1e-4);
        let weights = random((4, 9));
        let gradients = |result: &Tensor| {
            let weighted = (result * weights.as_tensor()).unwrap();
            weighted.sum_all().unwrap().backward().unwrap()
        };
        let (fused, plain) = (gradients(&fused), gradients(&plain));
        for variable in [&x, &first, &second] {
            let (a, b) = (fused.get(variable).unwrap(), plain.get(variable).unwrap());
            assert!(largest_difference(a, b) < 1e-3, "{a} {b}");
        }
    }
}

#[test]
fn a_value_that_is_no_number_does_not_hide() {
    let x = Tensor::new(&[[[1.0f32], [f32::NAN], [2.0]]], &Device::Cpu).unwrap();
    let layer = Tensor::new(&[[1.0f32], [0.0]], &Device::Cpu).unwrap();
    let result = shared_max(&x, &layer, &layer).unwrap();
    assert!(result.flatten_all().unwrap().to_vec1::<f32>().unwrap()[0].is_nan());
}

#[test]
fn layers_that_do_not_fit_are_refused() {
    let message = shared_max(&random((2, 3, 3)), &random((3, 5)), &random((6, 4)));
    assert!(message.unwrap_err().to_string().contains("do not fit"));
}
