//! What the quasi-Newton method remembers between two windows, as part of a run's state: all columns and
//! factors, with their products as they were summed, since the order of a sum is in its bits.

use super::{Column, Factor, QuasiNewton, Triangle};
use std::collections::VecDeque;
use words::bytes::{Error, Reader, Writer};

impl QuasiNewton {
    /// Writes all columns and factors.
    pub(in crate::acceleration) fn save(&self, state: &mut Writer) {
        state.u64(self.window);
        let columns: Vec<&Column> = self.columns.iter().collect();
        state.list(&columns, |state, Column { window, residual, image, products }| {
            state.u64(*window);
            state.f64s(residual);
            state.f64s(image);
            for of_block in products {
                state.f64s(&of_block.iter().copied().collect::<Vec<f64>>());
            }
        });
        let factors: Vec<&Factor> = self.factors.iter().collect();
        state.list(&factors, |state, Factor { images, observed, residuals, sizes, triangle }| {
            state.usize(residuals.len());
            let columns = images.iter().chain(observed).chain(residuals).chain(&triangle.columns);
            columns.chain([sizes]).for_each(|column| state.f64s(column));
        });
    }

    /// Goes to what [`save`](Self::save) wrote, of so many `unknowns` in so many `blocks`.
    pub(in crate::acceleration) fn restore(
        &mut self,
        state: &mut Reader<'_>,
        blocks: usize,
        unknowns: usize,
    ) -> Result<(), Error> {
        self.forget_last();
        self.window = state.u64("windows of the acceleration")?;
        let columns = state.list("columns", None, |state| {
            Ok(Column {
                window: state.u64("window of a column")?,
                residual: state.f64s("residuals of a column", Some(unknowns))?,
                image: state.f64s("images of a column", Some(unknowns))?,
                products: (0..blocks)
                    .map(|_| Ok(state.f64s("products of a column", None)?.into()))
                    .collect::<Result<Vec<VecDeque<f64>>, Error>>()?,
            })
        })?;
        for (newer, column) in columns.iter().enumerate() {
            let older = columns.len() - newer;
            if let Some(found) = column.products.iter().map(VecDeque::len).find(|found| *found != older) {
                return Err(state.refuse("products of a column", format!("{found} instead of {older}")));
            }
        }
        self.factors = state
            .list("factors", None, |state| {
                let count = state.usize("columns of a factor")?;
                let mut list = |field, length: &dyn Fn(usize) -> usize| {
                    let columns = (0..count).map(|column| state.f64s(field, Some(length(column))));
                    columns.collect::<Result<Vec<_>, Error>>()
                };
                let whole = |_| unknowns;
                Ok(Factor {
                    images: list("images of a factor", &whole)?,
                    observed: list("observations of a factor", &whole)?,
                    residuals: list("residuals of a factor", &whole)?,
                    triangle: Triangle { columns: list("triangle of a factor", &|column| column + 1)? },
                    sizes: state.f64s("sizes of a factor", Some(blocks))?,
                })
            })?
            .into();
        self.columns = columns.into();
        Ok(())
    }
}
