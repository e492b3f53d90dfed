//! The CSV of a figure: exactly the series that are drawn, numbers in shortest round-trip form.
//!
//! Two layouts, told apart by the first column. *Wide*, when all series share one x quantity and each ascends in it:
//! that quantity, then one column a series; a row for every abscissa that occurs, an empty cell where a series has no
//! value.
//! *Long* otherwise (orbits, Nyquist curves, bars, maps): `panel,series,x,y`. Column names carry the unit.
//! A band has its lower edge in a further column or series `… lower`, error bars in `… standard deviation`.

use super::figure::{Axis, Figure, Panel, SeriesShape};
use crate::report::tables::Table;

/// One plotted column: panel, name, abscissae, ordinates.
struct PlotColumn<'a> {
    panel: &'a Panel,
    name: String,
    x: &'a [f64],
    y: &'a [f64],
}

pub(super) fn csv(figure: &Figure) -> String {
    let columns = columns(figure);
    let keys: Vec<String> = figure.panels.iter().map(|p| key(&p.x)).collect();
    let no_maps = figure.panels.iter().all(|p| p.heat.is_none());
    let one_quantity = keys.windows(2).all(|k| k.first() == k.last());
    let ascending = columns.iter().all(|c| c.x.windows(2).all(|w| w.first() < w.last()));
    match keys.first() {
        Some(x_key) if no_maps && one_quantity && ascending && !columns.is_empty() => wide(figure, &columns, x_key),
        _ => long(figure, &columns),
    }
}

fn columns(figure: &Figure) -> Vec<PlotColumn<'_>> {
    let mut columns = Vec::new();
    for panel in &figure.panels {
        for s in &panel.series {
            let mut add = |suffix: &str, y| {
                let name = format!("{}{suffix}", s.name);
                columns.push(PlotColumn { panel, name, x: &s.x, y });
            };
            add("", &s.y);
            if let SeriesShape::Band { lower } = &s.shape {
                add(" lower", lower);
            }
            if let Some(error) = &s.y_error {
                add(" standard deviation", error);
            }
        }
    }
    columns
}

fn wide(figure: &Figure, columns: &[PlotColumn], x_key: &str) -> String {
    let several = figure.panels.len() > 1;
    let mut header = vec![x_key.to_owned()];
    for column in columns {
        let quantity = key(&column.panel.y);
        let panel = if several && !column.panel.title.is_empty() {
            format!("{}_", slug(&column.panel.title))
        } else {
            String::new()
        };
        let name = format!("{panel}{}_{quantity}", slug(&column.name));
        let repeats = header.iter().filter(|h| **h == name).count();
        header.push(if repeats > 0 { format!("{name}_{}", header.len()) } else { name });
    }
    let mut table = Table::new(header);
    let mut rows: Vec<f64> = columns.iter().flat_map(|c| c.x.iter().copied()).collect();
    rows.sort_by(f64::total_cmp);
    rows.dedup();
    let mut next = vec![0usize; columns.len()];
    for x in rows {
        let mut row = vec![x];
        for (column, at) in columns.iter().zip(&mut next) {
            let here = column.x.get(*at) == Some(&x);
            row.push(if here { column.y.get(*at).copied().unwrap_or(f64::NAN) } else { f64::NAN });
            *at += usize::from(here);
        }
        table.push_numbers(&row);
    }
    table.to_csv()
}

fn long(figure: &Figure, columns: &[PlotColumn]) -> String {
    let names = |f: fn(&Panel) -> &Axis, fallback: &str| {
        let mut keys = figure.panels.iter().map(|p| key(f(p)));
        let first = keys.next().unwrap_or_default();
        if keys.all(|k| k == first) && !first.is_empty() { first } else { fallback.to_owned() }
    };
    let (x_key, y_key) = (names(|p| &p.x, "x"), names(|p| &p.y, "y"));
    let y_key = if y_key == x_key { format!("{y_key}_y") } else { y_key };
    let mut table = Table::new(vec!["panel".to_owned(), "series".to_owned(), x_key, y_key]);
    for column in columns {
        for (x, y) in column.x.iter().zip(column.y) {
            let position = |axis: &Axis, v: f64| {
                // A named position is written by its name.
                let named = (v >= 0.0 && v.fract() == 0.0).then(|| axis.categories.get(v as usize)).flatten();
                named.cloned().unwrap_or_else(|| Table::number(v))
            };
            let (x, y) = (position(&column.panel.x, *x), position(&column.panel.y, *y));
            table.push(vec![column.panel.title.clone(), column.name.clone(), x, y]);
        }
    }
    for panel in &figure.panels {
        let Some(heat) = &panel.heat else { continue };
        for (row, values) in heat.values.iter().enumerate() {
            let name = panel.y.categories.get(row).cloned().unwrap_or_else(|| row.to_string());
            for (value, edges) in values.iter().zip(heat.x_edges.windows(2)) {
                let middle = 0.5 * edges.iter().sum::<f64>();
                let cells = [heat.label.clone(), name.clone(), Table::number(middle), Table::number(*value)];
                table.push(cells.to_vec());
            }
        }
    }
    table.to_csv()
}

/// `Dynamic stiffness` in `N/µm` → `dynamic_stiffness_n_per_um`.
fn key(axis: &Axis) -> String {
    let unit = axis.unit.replace('°', "deg").replace('µ', "u").replace('/', " per ").replace('·', " ");
    let parts: Vec<String> = [slug(&axis.label), slug(&unit)].into_iter().filter(|p| !p.is_empty()).collect();
    parts.join("_")
}

fn slug(text: &str) -> String {
    let mut out = String::new();
    for c in text.replace('µ', "mu").replace('σ', "sigma").to_lowercase().chars() {
        if c.is_alphanumeric() {
            out.push(c);
        } else if !out.is_empty() && !out.ends_with('_') {
            out.push('_');
        }
    }
    out.trim_end_matches('_').to_owned()
}
