//! Kernels cut down to what a scene calls for: `override` constants evaluated, branches on them decided, and what is
//! then out of reach removed: statements, local variables, functions, constants, types and bindings.
//!
//! The text that comes out is canonical: naga writes it, and its declarations stand in a fixed order. An effect that
//! a scene does not call for leaves no trace in it: `tests/wgsl.rs` compares the kernels of such a scene with those of a
//! source tree that did not know the effect.

use super::kernel::Constants;
use super::wgsl::Composed;
use naga::back::{PipelineConstants, pipeline_constants::process_overrides, wgsl::WriterFlags, wgsl::write_string};
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Block, Expression, Function, Handle, Literal, LocalVariable, Module, Statement, WithSpan};
use std::collections::{HashMap, HashSet};

/// A kernel cut down.
#[derive(Clone, Debug)]
pub struct Special {
    /// Canonical WGSL.
    pub source: String,
    /// The bindings that are left, in order.
    pub bindings: Vec<u32>,
    /// Expressions and statements that are left.
    pub instructions: usize,
}

/// Cuts a kernel down to what `constants` call for; names that it does not know are not for it.
///
/// Errors: what naga says of a text that it refuses, led back to its file and line.
pub fn specialise(composed: &Composed, constants: &Constants) -> Result<Special, String> {
    let place = |line: Option<naga::SourceLocation>| line.map_or(String::new(), |l| composed.locate(l.line_number as usize));
    let source = &composed.source;
    let mut module = naga::front::wgsl::parse_str(source)
        .map_err(|e| format!("{}: {}", place(e.location(source)), e.emit_to_string(source)))?;
    let info = validate(&module).map_err(|e| format!("{}: {}", place(e.location(source)), e.emit_to_string(source)))?;

    // Overrides become numbers, and what follows from them is evaluated.
    let known: HashSet<&str> = module.overrides.iter().filter_map(|(_, o)| o.name.as_deref()).collect();
    let values: PipelineConstants =
        constants.iter().filter(|(name, _)| known.contains(name)).map(|(name, value)| (name.into(), value)).collect();
    module = process_overrides(&module, &info, None, &values).map_err(|e| format!("its constants: {e}"))?.0.into_owned();

    // Cut, and sweep up. Names keep variables and constants alive, so these are looked through between two sweeps.
    cut_module(&mut module);
    compact(&mut module, KeepUnused::No);
    forget_unused(&mut module);
    compact(&mut module, KeepUnused::No);

    let info = validate(&module).map_err(|e| format!("cut down: {}", e.emit_to_string("")))?;
    let written = write_string(&module, &info, WriterFlags::empty()).map_err(|e| format!("writing: {e}"))?;
    let bound = module.global_variables.iter().filter_map(|(_, v)| v.binding.as_ref());
    let mut bindings: Vec<u32> = bound.map(|b| b.binding).collect();
    bindings.sort_unstable();
    Ok(Special { source: in_order(&written), bindings, instructions: instructions(&module) })
}

fn validate(module: &Module) -> Result<ModuleInfo, Box<WithSpan<naga::valid::ValidationError>>> {
    Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(module).map_err(Box::new)
}

/// All functions of a module, the entry's last.
fn functions(module: &mut Module) -> impl Iterator<Item = &mut Function> {
    let entries = module.entry_points.iter_mut().map(|e| &mut e.function);
    module.functions.iter_mut().map(|(_, f)| f).chain(entries)
}

// -----------------------------------------------------------------------------------------------
// Branches that are decided
// -----------------------------------------------------------------------------------------------

fn cut_module(module: &mut Module) {
    let (constants, globals) = (module.constants.clone(), module.global_expressions.clone());
    let literal = |e: &Expression| match e {
        Expression::Literal(Literal::Bool(is)) => Some(*is),
        _ => None,
    };
    for function in functions(module) {
        let expressions = &function.expressions;
        let known = |condition: Handle<Expression>| match &expressions[condition] {
            Expression::Constant(c) => literal(&globals[constants[*c].init]),
            other => literal(other),
        };
        let (body, _) = cut(std::mem::take(&mut function.body), &known);
        // What a branch named that is gone has no name any more.
        let mut found = HashSet::new();
        results(&body, &mut found);
        function.named_expressions.retain(|e, _| found.contains(e));
        function.body = body;
    }
}

/// A block without what can not be reached, and whether its end can not.
fn cut(block: Block, known: &impl Fn(Handle<Expression>) -> Option<bool>) -> (Block, bool) {
    let mut out = Block::with_capacity(block.len());
    for (statement, span) in block.span_into_iter() {
        let left = matches!(statement, Statement::Return { .. } | Statement::Break | Statement::Continue | Statement::Kill);
        match statement {
            Statement::If { condition, accept, reject } => match known(condition) {
                Some(is) => {
                    let (taken, left) = cut(if is { accept } else { reject }, known);
                    out.extend_block(taken);
                    if left {
                        return (out, true);
                    }
                }
                None => out.push(Statement::If { condition, accept: cut(accept, known).0, reject: cut(reject, known).0 }, span),
            },
            Statement::Block(inner) => {
                let (inner, left) = cut(inner, known);
                out.push(Statement::Block(inner), span);
                if left {
                    return (out, true);
                }
            }
            Statement::Loop { body, continuing, break_if } => {
                out.push(Statement::Loop { body: cut(body, known).0, continuing: cut(continuing, known).0, break_if }, span)
            }
            Statement::Switch { selector, mut cases } => {
                for case in &mut cases {
                    case.body = cut(std::mem::take(&mut case.body), known).0;
                }
                out.push(Statement::Switch { selector, cases }, span);
            }
            other => out.push(other, span),
        }
        if left {
            return (out, true);
        }
    }
    (out, false)
}

/// The expressions that statements of a block bring about.
fn results(block: &Block, found: &mut HashSet<Handle<Expression>>) {
    for statement in block {
        match statement {
            Statement::Emit(range) => found.extend(range.clone()),
            Statement::Call { result: Some(e), .. } | Statement::Atomic { result: Some(e), .. } => {
                found.insert(*e);
            }
            Statement::WorkGroupUniformLoad { result, .. } => {
                found.insert(*result);
            }
            _ => {}
        }
        blocks(statement).for_each(|inner| results(inner, found));
    }
}

/// The blocks within a statement.
fn blocks(statement: &Statement) -> impl Iterator<Item = &Block> {
    let inner: Vec<&Block> = match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Loop { body, continuing, .. } => vec![body, continuing],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        _ => vec![],
    };
    inner.into_iter()
}

// -----------------------------------------------------------------------------------------------
// Names of what is not used
// -----------------------------------------------------------------------------------------------

/// Drops local variables that no expression speaks of, and the names of such constants, of a module that was swept.
fn forget_unused(module: &mut Module) {
    let mut constants = HashSet::new();
    let mut note = |e: &Expression| {
        if let Expression::Constant(c) = e {
            constants.insert(*c);
        }
    };
    module.global_expressions.iter().for_each(|(_, e)| note(e));
    for function in functions(module) {
        function.expressions.iter().for_each(|(_, e)| note(e));
        let used: HashSet<Handle<LocalVariable>> = function.expressions.iter().filter_map(|(_, e)| local(e)).collect();
        let mut moved = HashMap::new();
        for (handle, variable, span) in function.local_variables.take().drain() {
            if used.contains(&handle) {
                moved.insert(handle, function.local_variables.append(variable, span));
            }
        }
        for (_, e) in function.expressions.iter_mut() {
            if let Expression::LocalVariable(v) = e {
                *v = moved[v];
            }
        }
    }
    for (handle, constant) in module.constants.iter_mut() {
        if !constants.contains(&handle) {
            constant.name = None;
        }
    }
}

fn local(e: &Expression) -> Option<Handle<LocalVariable>> {
    match e {
        Expression::LocalVariable(v) => Some(*v),
        _ => None,
    }
}

// -----------------------------------------------------------------------------------------------
// The text
// -----------------------------------------------------------------------------------------------

/// The declarations of a written module in an order of their own: WGSL lets them stand in any.
fn in_order(written: &str) -> String {
    let (mut all, mut one) = (Vec::new(), String::new());
    for line in written.lines().filter(|line| !line.is_empty()) {
        one.push_str(line);
        one.push('\n');
        if line == "}" || (line.ends_with(';') && !line.starts_with(' ')) {
            all.push(std::mem::take(&mut one));
        }
    }
    // By kind, then by text; bindings by number, the entry last.
    let place = |text: &String| {
        let binding = text.split_once("@binding(").and_then(|(_, rest)| rest.split(')').next()?.parse().ok());
        let kinds = ["enable", "const", "struct", "@group", "var", "fn", "@compute"];
        (kinds.iter().position(|kind| text.starts_with(kind)), binding.unwrap_or(0u32))
    };
    all.sort_by(|a, b| place(a).cmp(&place(b)).then_with(|| a.cmp(b)));
    all.join("\n")
}

/// Expressions and statements of a module's functions.
fn instructions(module: &Module) -> usize {
    fn statements(block: &Block) -> usize {
        block.iter().map(|s| 1 + blocks(s).map(statements).sum::<usize>()).sum()
    }
    let of = |f: &Function| f.expressions.len() + statements(&f.body);
    module.functions.iter().map(|(_, f)| of(f)).sum::<usize>()
        + module.entry_points.iter().map(|e| of(&e.function)).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
        override LIGHTS: bool = false;
        override SIGMA: f32 = 0.0;
        const MANY = 7u;
        struct Light { p: vec3<f32>, power: f32 }
        @group(0) @binding(1) var<storage, read> lights: array<Light>;
        @group(0) @binding(2) var<storage, read_write> out: array<f32>;
        fn shine(i: u32) -> f32 {
            var sum = 0.0;
            for (var k = 0u; k < MANY; k++) { sum += lights[i + k].power; }
            return sum;
        }
        fn seen(x: f32) -> f32 {
            if SIGMA > 0.0 { return exp(-SIGMA * x); }
            return x;
        }
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            var x = seen(2.0);
            if LIGHTS { let brought = shine(id.x); x += brought; }
            out[id.x] = x;
        }";

    fn special(constants: Constants) -> Special {
        let composed = Composed { source: TEXT.into(), lines: (1..=TEXT.lines().count()).map(|i| ("text".into(), i)).collect() };
        specialise(&composed, &constants).unwrap()
    }

    #[test]
    fn what_is_not_called_for_leaves_no_trace() {
        let none = special(Constants::NONE);
        assert_eq!(none.bindings, [2]);
        for word in ["LIGHTS", "SIGMA", "MANY", "Light", "lights", "shine", "sum", "exp", "if", "brought"] {
            assert!(!none.source.contains(word), "{word}: {}", none.source);
        }
        let lit = special(Constants::NONE.with("LIGHTS", true));
        assert_eq!(lit.bindings, [1, 2]);
        assert!(lit.source.contains("fn shine") && lit.source.contains("const MANY"), "{}", lit.source);
        assert!(lit.instructions > none.instructions);
        let dim = special(Constants::NONE.with("SIGMA", 0.5f32).with("NOBODY", true));
        assert!(dim.source.contains("exp(") && dim.source.contains("-0.5"), "{}", dim.source);
    }

    #[test]
    fn declarations_stand_in_any_order() {
        let turned: String = {
            let (head, tail) = TEXT.split_once("fn seen").unwrap();
            let (seen, main) = tail.split_once("@compute").unwrap();
            format!("fn seen{seen}\n@compute{main}\n{head}")
        };
        let composed = Composed { source: turned, lines: Vec::new() };
        let lit = Constants::NONE.with("LIGHTS", true).with("SIGMA", 1.0f32);
        assert_eq!(specialise(&composed, &lit).unwrap().source, special(lit).source);
    }

    #[test]
    fn a_bad_text_is_refused_with_its_line() {
        let composed = Composed {
            source: "fn f() -> u32 {\n return nobody;\n}\n".into(),
            lines: vec![("x.wgsl".into(), 1), ("x.wgsl".into(), 2)],
        };
        let told = specialise(&composed, &Constants::NONE).unwrap_err();
        assert!(told.starts_with("x.wgsl:2: "), "{told}");
    }
}
