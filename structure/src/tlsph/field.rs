//! Vector fields over the internal particle order, as flat structure of arrays.

use sph::Vector;

/// `components × particles` numbers, component after component, each with the same margin of zeros before and
/// after its particles, so that runs of neighbours may reach past the ends.
#[derive(Clone, Debug, Default)]
pub(crate) struct Field {
    data: Vec<f64>,
    components: usize,
    margin: usize,
    count: usize,
}

impl Field {
    /// Zeros.
    pub fn new(components: usize, margin: usize, count: usize) -> Self {
        Self { data: vec![0.0; components * (count + 2 * margin)], components, margin, count }
    }

    /// All values of component `i`, margins included.
    #[inline(always)]
    pub fn component(&self, i: usize) -> &[f64] {
        let stride = self.count + 2 * self.margin;
        &self.data[i * stride..(i + 1) * stride]
    }

    /// The components, margins included.
    #[inline(always)]
    pub fn components<const N: usize>(&self) -> [&[f64]; N] {
        debug_assert_eq!(N, self.components);
        std::array::from_fn(|i| self.component(i))
    }

    /// Rows `r` of `N` components each, margins included: component `r N + i`.
    #[inline(always)]
    pub fn rows<const R: usize, const N: usize>(&self) -> [[&[f64]; N]; R] {
        debug_assert_eq!(R * N, self.components);
        std::array::from_fn(|r| std::array::from_fn(|i| self.component(r * N + i)))
    }

    /// The particles' values of each component, margins left out.
    pub fn interior_mut<const N: usize>(&mut self) -> [&mut [f64]; N] {
        debug_assert_eq!(N, self.components);
        let (margin, count) = (self.margin, self.count);
        let mut chunks = self.data.chunks_exact_mut((count + 2 * margin).max(1));
        std::array::from_fn(|_| match chunks.next() {
            Some(chunk) => &mut chunk[margin..margin + count],
            None => Default::default(),
        })
    }

    /// As [`Field::interior_mut`], in rows of `N`.
    pub fn interior_rows_mut<const R: usize, const N: usize>(&mut self) -> [[&mut [f64]; N]; R] {
        debug_assert_eq!(R * N, self.components);
        let (margin, count) = (self.margin, self.count);
        let mut chunks = self.data.chunks_exact_mut((count + 2 * margin).max(1));
        std::array::from_fn(|_| {
            std::array::from_fn(|_| match chunks.next() {
                Some(chunk) => &mut chunk[margin..margin + count],
                None => Default::default(),
            })
        })
    }

    /// Value of component `i` at particle `a`.
    #[inline]
    pub fn get(&self, i: usize, a: usize) -> f64 {
        self.data[i * (self.count + 2 * self.margin) + self.margin + a]
    }

    /// Sets component `i` at particle `a`.
    #[inline]
    pub fn set(&mut self, i: usize, a: usize, value: f64) {
        self.data[i * (self.count + 2 * self.margin) + self.margin + a] = value;
    }

    /// The vector at particle `a`.
    #[inline]
    pub fn vector<const D: usize>(&self, a: usize) -> Vector<D> {
        Vector::from_fn(|i, _| self.get(i, a))
    }

    /// Sets the vector at particle `a`.
    #[inline]
    pub fn set_vector<const D: usize>(&mut self, a: usize, value: &Vector<D>) {
        for i in 0..D {
            self.set(i, a, value[i]);
        }
    }

    /// All zero.
    pub fn clear(&mut self) {
        self.data.fill(0.0);
    }
}
