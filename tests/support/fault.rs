//! Faults planted in passes, by their syntax trees.

use naga::{
    Expression, ScalarKind,
    valid::{Capabilities, ValidationFlags, Validator},
};
use windswept::{Gpu, internals::with_sources};
use windswept_shaders::Pass;

/// The device with a fault in a pass: value `n` is `factor` times what it should be, an integer 1 too large, a truth
/// value the opposite. The values of a pass are its literals, operations, loads, components and results of calls, in
/// the order of its linked WGSL, in which its own file comes first. A number too large lists them.
pub fn plant(gpu: &Gpu, pass: &'static Pass, n: usize, factor: f32) -> Gpu {
    let text = pass.source;
    let module = naga::front::wgsl::parse_str(text).unwrap();
    let info = Validator::new(ValidationFlags::all(), Capabilities::SUBGROUP).validate(&module).unwrap();
    let functions = module.functions.iter().map(|(handle, function)| (function, &info[handle]));
    let entry = (&module.entry_points[0].function, info.get_entry_point(0));
    let constants = module.global_expressions.iter().map(|(handle, expression)| {
        (expression, module.global_expressions.get_span(handle), info[handle].inner_with(&module.types))
    });
    let expressions = functions.chain([entry]).flat_map(|(function, info)| {
        function.expressions.iter().map(|(handle, expression)| {
            (expression, function.expressions.get_span(handle), info[handle].ty.inner_with(&module.types))
        })
    });
    let mut values: Vec<_> = constants
        .chain(expressions)
        .filter(|(expression, ..)| {
            use Expression::{AccessIndex, Binary, CallResult, Literal, Load};
            matches!(expression, Literal(_) | Binary { .. } | Load { .. } | AccessIndex { .. } | CallResult(_))
        })
        .filter_map(|(_, span, kind)| Some((span.to_range()?, kind.scalar_kind()?)))
        .collect();
    values.sort_by_key(|(at, _)| (at.start, at.end));
    values.dedup_by_key(|(at, _)| at.clone());
    let all = || -> Vec<_> { values.iter().enumerate().map(|(n, (at, _))| (n, &text[at.clone()])).collect() };
    let (at, kind) = values.get(n).unwrap_or_else(|| panic!("{} has no value {n}: {:#?}", pass.name, all()));
    let value = &text[at.clone()];
    let wrong = match kind {
        ScalarKind::Float | ScalarKind::AbstractFloat => format!("({factor:?} * ({value}))"),
        ScalarKind::Sint | ScalarKind::Uint | ScalarKind::AbstractInt => format!("(({value}) + 1)"),
        ScalarKind::Bool => format!("!({value})"),
    };
    println!("{} with {wrong}, value {n}", pass.name);
    with_sources(gpu, [(pass.name, [&text[..at.start], &wrong, &text[at.end..]].concat())])
}
