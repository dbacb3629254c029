//! Random bytes of messages that their layout allows, for the fuzz test.

use super::{Item, Layout};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

impl Layout {
    /// Bytes that this layout allows: any numbers, short arrays and strings.
    pub(crate) fn example(&self, random: &mut Pcg64Mcg, bytes: &mut Vec<u8>) {
        for item in &self.0 {
            match item {
                Item::Fixed(size) => {
                    // Zero and one are frequent, so that flags and small counts occur.
                    let small = random.random_bool(0.5);
                    let byte = |random: &mut Pcg64Mcg| {
                        if small {
                            random.random_range(0..2)
                        } else {
                            random.random()
                        }
                    };
                    bytes.extend((0..*size).map(|_| byte(random)));
                }
                Item::Truth(count) => {
                    bytes.extend((0..*count).map(|_| random.random_range(0..2)));
                }
                Item::Array(element) => {
                    let text = *element == Self(vec![Item::Fixed(1)]);
                    let count = random.random_range(0..if text { 12 } else { 4 });
                    bytes.extend(u32::to_le_bytes(count));
                    for _ in 0..count {
                        match text {
                            true => bytes.push(random.random_range(b' '..b'~')),
                            false => element.example(random, bytes),
                        }
                    }
                }
            }
        }
    }
}
