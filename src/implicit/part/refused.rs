//! Names of what a part file may not hold, and the way from a wrong word to the right one.

use ruff_python_ast::{Expr, Stmt};

/// What to call a statement that is refused, and what to write instead.
pub(super) fn statement(s: &Stmt) -> (&'static str, &'static str) {
    match s {
        Stmt::While(_) => ("endless loops", "use for i in range(n):"),
        Stmt::Import(_) | Stmt::ImportFrom(_) => {
            ("other imports than math, numpy and rvachev", "everything there is has a name already")
        }
        Stmt::FunctionDef(_) => ("functions inside functions", "define it before"),
        Stmt::AnnAssign(_) => ("annotations", "write name = value"),
        Stmt::ClassDef(_) => ("classes", "use functions"),
        Stmt::Return(_) => ("returns outside of functions", "remove it"),
        other => {
            let what = match other {
                Stmt::With(_) => "with statements",
                Stmt::Try(_) => "try statements",
                Stmt::Raise(_) => "raise statements",
                Stmt::Assert(_) => "assertions",
                Stmt::Delete(_) => "del statements",
                Stmt::Global(_) => "global statements",
                Stmt::Nonlocal(_) => "nonlocal statements",
                Stmt::Match(_) => "match statements",
                Stmt::TypeAlias(_) => "type aliases",
                _ => "such statements",
            };
            (what, "a part file holds assignments, functions, and calls")
        }
    }
}

/// What to write instead of a name that other languages have.
pub(super) fn name(name: &str) -> Option<&'static str> {
    Some(match name {
        "where" => "write a if condition else b",
        "clip" => "write clamp(f, low, high)",
        "length" | "norm" => "write hypot(a, b, c)",
        "mix" => "write a*(1 - t) + b*t",
        _ => return None,
    })
}

/// What to call an expression that is refused.
pub(super) fn expression(e: &Expr) -> &'static str {
    match e {
        Expr::Lambda(_) => "lambda functions",
        Expr::Dict(_) | Expr::DictComp(_) => "dictionaries",
        Expr::Set(_) | Expr::SetComp(_) => "sets",
        Expr::Named(_) => "assignments inside expressions",
        Expr::Starred(_) => "starred expressions",
        Expr::BytesLiteral(_) => "byte strings",
        Expr::TString(_) => "template strings",
        Expr::Yield(_) | Expr::YieldFrom(_) => "yield expressions",
        Expr::Await(_) => "await expressions",
        Expr::EllipsisLiteral(_) => "ellipses",
        _ => "such expressions",
    }
}
