//! How many operations on floats a pass does, counted in its text.
//!
//! An operation is an addition, a multiplication, a division, a comparison, a root or any other function of a number,
//! per component; a dot product of n components has 2n − 1. Of the two ways of a branch the longer one counts. A loop
//! of a fixed number of iterations counts so often. The loop over a batch of neighbours (`common/clusters.wgsl`) is
//! counted apart, since the host knows how many batches there are. Any other loop has an unknown number of iterations:
//! it counts once, and `more` is set.

use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction, Module, Scalar,
    ScalarKind, Statement, TypeInner, UnaryOperator,
    proc::TypeResolution,
    valid::{FunctionInfo, ModuleInfo},
};

/// The function with the loop over batches, and those that call it.
const BATCHES: &str = "meet_batches";
const OWN_KIND: &str = "meet_own_kind";
const OTHER_KIND: &str = "meet_other_kind";
const BOTH_KINDS: &str = "meet_both_kinds";

/// Operations of an invocation of a pass.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Operations {
    /// Outside of the loop over batches.
    pub(crate) invocation: u64,
    /// In each batch of neighbours of its own kind.
    pub(crate) own_batch: u64,
    /// In each batch of the other kind.
    pub(crate) other_batch: u64,
    /// Whether there is a loop with an unknown number of iterations, which counts once.
    pub(crate) more: bool,
}

/// Operations of a part of a pass.
#[derive(Clone, Copy, Default)]
struct Count {
    straight: u64,
    batch: u64,
    own: u64,
    other: u64,
    more: bool,
}

impl Count {
    fn plus(self, other: Self) -> Self {
        Self {
            straight: self.straight + other.straight,
            batch: self.batch + other.batch,
            own: self.own + other.own,
            other: self.other + other.other,
            more: self.more | other.more,
        }
    }

    fn all(self) -> u64 {
        self.straight + self.batch + self.own + self.other
    }
}

/// Operations of the pass that is a module's first entry point.
pub(crate) fn operations(module: &Module, info: &ModuleInfo) -> Operations {
    let function = &module.entry_points[0].function;
    let count = Counter { module, info, function, types: info.get_entry_point(0) }.block(&function.body);
    Operations { invocation: count.straight, own_batch: count.own, other_batch: count.other, more: count.more }
}

struct Counter<'a> {
    module: &'a Module,
    info: &'a ModuleInfo,
    function: &'a Function,
    types: &'a FunctionInfo,
}

impl Counter<'_> {
    fn block(&self, block: &Block) -> Count {
        block.iter().fold(Count::default(), |sum, statement| sum.plus(self.statement(statement)))
    }

    fn statement(&self, statement: &Statement) -> Count {
        match statement {
            Statement::Emit(range) => {
                let straight = range.clone().map(|handle| self.expression(handle)).sum();
                Count { straight, ..Count::default() }
            }
            Statement::Block(block) => self.block(block),
            Statement::If { accept, reject, .. } => {
                let (accept, reject) = (self.block(accept), self.block(reject));
                if accept.all() >= reject.all() { accept } else { reject }
            }
            Statement::Switch { cases, .. } => {
                cases.iter().map(|case| self.block(&case.body)).max_by_key(|case| case.all()).unwrap_or_default()
            }
            Statement::Loop { body, continuing, .. } => self.turns(body, continuing),
            Statement::Call { function, .. } => self.call(*function),
            _ => Count::default(),
        }
    }

    fn call(&self, called: Handle<Function>) -> Count {
        let function = &self.module.functions[called];
        let count = Counter { function, types: &self.info[called], ..*self }.block(&function.body);
        match function.name.as_deref() {
            Some(OWN_KIND) => Count { batch: 0, own: count.own + count.batch, ..count },
            Some(OTHER_KIND) => Count { batch: 0, other: count.other + count.batch, ..count },
            // The loop of this function has a turn for each kind.
            Some(BOTH_KINDS) => {
                let half = count.batch / 2;
                Count { batch: 0, own: count.own + half, other: count.other + half, ..count }
            }
            _ => count,
        }
    }

    /// A loop: of a fixed number of turns, or one of the two over groups of batches and over the batches of a group.
    fn turns(&self, body: &Block, continuing: &Block) -> Count {
        let once = self.block(body).plus(self.block(continuing));
        if self.function.name.as_deref() == Some(BATCHES) {
            // Operations once a group are few, and count as if they were done once a batch.
            return Count { straight: 0, batch: once.all(), ..once };
        }
        let Some(turns) = self.fixed_turns(body) else { return Count { more: true, ..once } };
        Count {
            straight: once.straight * turns,
            batch: once.batch * turns,
            own: once.own * turns,
            other: once.other * turns,
            ..once
        }
    }

    /// The number of turns of `for (var k = 0u; k < N; k++)`.
    fn fixed_turns(&self, body: &Block) -> Option<u64> {
        body.iter().find_map(|statement| {
            let Statement::If { condition, .. } = statement else { return None };
            let Expression::Binary { op: BinaryOperator::Less, left, right } = self.function.expressions[*condition]
            else {
                return None;
            };
            let Expression::Load { pointer } = self.function.expressions[left] else { return None };
            let Expression::LocalVariable(counter) = self.function.expressions[pointer] else { return None };
            self.counts_up(counter).then(|| self.number(right)).flatten()
        })
    }

    /// Whether a variable begins at 0 and nothing but 1 is ever added to it.
    fn counts_up(&self, variable: Handle<LocalVariable>) -> bool {
        let zero = |value| self.number(value) == Some(0);
        let one_more = |value| match self.function.expressions[value] {
            Expression::Binary { op: BinaryOperator::Add, left, right } => {
                matches!(self.function.expressions[left], Expression::Load { .. }) && self.number(right) == Some(1)
            }
            _ => false,
        };
        let begins = self.function.local_variables[variable].init.is_none_or(zero);
        begins && self.stored(&self.function.body, variable).into_iter().all(|value| zero(value) || one_more(value))
    }

    /// Values stored in a variable.
    fn stored(&self, block: &Block, variable: Handle<LocalVariable>) -> Vec<Handle<Expression>> {
        let inside =
            |blocks: &[&Block]| blocks.iter().flat_map(|block| self.stored(block, variable)).collect::<Vec<_>>();
        let stored = block.iter().flat_map(|statement| match statement {
            Statement::Store { pointer, value } => {
                let own =
                    matches!(self.function.expressions[*pointer], Expression::LocalVariable(own) if own == variable);
                if own { vec![*value] } else { Vec::new() }
            }
            Statement::Block(block) => inside(&[block]),
            Statement::If { accept, reject, .. } => inside(&[accept, reject]),
            Statement::Loop { body, continuing, .. } => inside(&[body, continuing]),
            Statement::Switch { cases, .. } => inside(&cases.iter().map(|case| &case.body).collect::<Vec<_>>()),
            _ => Vec::new(),
        });
        stored.collect()
    }

    fn number(&self, handle: Handle<Expression>) -> Option<u64> {
        match self.function.expressions[handle] {
            Expression::Literal(Literal::U32(n)) => Some(n.into()),
            Expression::Literal(Literal::I32(n)) => n.try_into().ok(),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(Literal::U32(n)) => Some(n.into()),
                    Expression::Literal(Literal::I32(n)) => n.try_into().ok(),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    fn inner(&self, handle: Handle<Expression>) -> &TypeInner {
        match &self.types[handle].ty {
            TypeResolution::Handle(ty) => &self.module.types[*ty].inner,
            TypeResolution::Value(inner) => inner,
        }
    }

    /// Components of a value if they are floats.
    fn floats(&self, handle: Handle<Expression>) -> Option<u64> {
        let is_float = |scalar: &Scalar| scalar.kind == ScalarKind::Float;
        match self.inner(handle) {
            TypeInner::Scalar(scalar) if is_float(scalar) => Some(1),
            TypeInner::Vector { size, scalar } if is_float(scalar) => Some(*size as u64),
            TypeInner::Matrix { columns, rows, scalar } if is_float(scalar) => Some(*columns as u64 * *rows as u64),
            _ => None,
        }
    }

    fn expression(&self, handle: Handle<Expression>) -> u64 {
        match self.function.expressions[handle] {
            Expression::Unary { op: UnaryOperator::Negate, expr } => self.floats(expr).unwrap_or(0),
            Expression::Binary { op, left, right } => {
                let (Some(left_size), Some(right_size)) = (self.floats(left), self.floats(right)) else { return 0 };
                match (op, self.inner(left), self.inner(right)) {
                    (BinaryOperator::Multiply, TypeInner::Matrix { columns, rows, .. }, TypeInner::Vector { .. }) => {
                        *rows as u64 * (2 * *columns as u64 - 1)
                    }
                    (BinaryOperator::Multiply, TypeInner::Vector { .. }, TypeInner::Matrix { columns, rows, .. }) => {
                        *columns as u64 * (2 * *rows as u64 - 1)
                    }
                    (
                        BinaryOperator::Multiply,
                        TypeInner::Matrix { columns: inside, rows, .. },
                        TypeInner::Matrix { columns, .. },
                    ) => *rows as u64 * *columns as u64 * (2 * *inside as u64 - 1),
                    _ => left_size.max(right_size),
                }
            }
            Expression::Math { fun, arg, .. } => {
                let Some(n) = self.floats(arg) else { return 0 };
                match fun {
                    MathFunction::Dot => 2 * n - 1,
                    MathFunction::Length => 2 * n,
                    MathFunction::Distance | MathFunction::Normalize => 3 * n,
                    MathFunction::Cross => 9,
                    MathFunction::Fma | MathFunction::Clamp => 2 * n,
                    MathFunction::Mix => 3 * n,
                    MathFunction::Transpose => 0,
                    _ => n,
                }
            }
            _ => 0,
        }
    }
}
