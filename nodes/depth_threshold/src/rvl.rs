//! Decoder of RVL, a lossless compression of depths (Wilson, "Fast Lossless Depth Image Compression", ISS 2017).
//!
//! The stream alternates between the number of zeros, the number of other depths, and for each of these the difference from
//! the one before, zigzag-coded (the sign is the lowest bit). Each number is a sequence of nibbles with three bits of data,
//! lowest first; the nibble's top bit tells that more follow. Eight nibbles are packed into a little-endian 32-bit word,
//! the first one highest.

/// Decodes exactly `count` depths; `None` if the data hold another number.
pub(crate) fn decode(packed: &[u8], count: usize) -> Option<Vec<u16>> {
    let mut nibbles = Nibbles { packed, taken: 0 };
    let mut depths = Vec::with_capacity(count);
    let mut depth = 0_u16;
    while depths.len() < count {
        let (zeros, others) = (nibbles.number()?, nibbles.number()?);
        // Two counts of 0 in turn make no progress; refuse them, or damaged data could loop for ever.
        if zeros + others == 0 || zeros + others > count - depths.len() {
            return None;
        }
        depths.resize(depths.len() + zeros, 0);
        for _ in 0..others {
            let folded = nibbles.number()? as u32;
            let difference = (folded >> 1) ^ (folded & 1).wrapping_neg();
            depth = depth.wrapping_add(difference as u16);
            depths.push(depth);
        }
    }
    Some(depths)
}

struct Nibbles<'a> {
    packed: &'a [u8],
    taken: usize,
}

impl Nibbles<'_> {
    fn number(&mut self) -> Option<usize> {
        let mut number = 0_usize;
        // No number of a depth image takes more than 30 bits.
        for place in 0..10 {
            let nibble = self.next()?;
            number |= usize::from(nibble & 7) << (3 * place);
            if nibble & 8 == 0 {
                return Some(number);
            }
        }
        None
    }

    fn next(&mut self) -> Option<u8> {
        let (word, place) = (self.taken / 8, self.taken % 8);
        // The last byte of a word comes first, and of each byte the upper half.
        let byte = *self.packed.get(4 * word + 3 - place / 2)?;
        self.taken += 1;
        Some(if place.is_multiple_of(2) {
            byte >> 4
        } else {
            byte & 15
        })
    }
}
