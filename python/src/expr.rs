//! Formulas in x, y, z: operators, comparisons, and what functions of numpy make of them.

use numpy::{PyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::basic::CompareOp;
use pyo3::exceptions::{PyTypeError, PyZeroDivisionError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rvachev::implicit::Expr;
use rvachev::implicit::expr::{Binary, Unary};

use crate::solid::PySolid;

/// A formula in the coordinates x, y and z.
///
/// Operators, comparisons (which give solids) and functions of numpy make new ones. `rvachev.x`, `rvachev.y` and `rvachev.z` are
/// where they start.
#[pyclass(frozen, name = "Expr", module = "rvachev", skip_from_py_object)]
#[derive(Clone)]
pub struct PyExpr {
    /// The formula.
    pub expr: Expr,
}

impl PyExpr {
    fn of(expr: Expr) -> Self {
        PyExpr { expr }
    }

    fn with(&self, op: Unary) -> Self {
        Self::of(Expr::unary(op, self.expr.clone()))
    }
}

/// A formula, or a number as one; nothing for anything else.
pub fn formula(v: &Bound<'_, PyAny>) -> Option<Expr> {
    if let Ok(e) = v.cast::<PyExpr>() {
        return Some(e.get().expr.clone());
    }
    if v.cast::<PyUntypedArray>().is_ok_and(|a| a.ndim() > 0) || v.cast::<PySolid>().is_ok() {
        return None;
    }
    v.extract::<f64>().ok().map(Expr::constant)
}

/// Two operands, the first one's own; `NotImplemented` where there is no formula.
fn two(py: Python<'_>, a: &Expr, b: &Bound<'_, PyAny>, op: Binary, turned: bool) -> PyResult<Py<PyAny>> {
    let Some(b) = formula(b) else { return Ok(py.NotImplemented()) };
    let (a, b) = if turned { (b, a.clone()) } else { (a.clone(), b) };
    made(py, op, a, b)
}

/// `a // b`
fn quotient(py: Python<'_>, a: Expr, b: Expr) -> PyResult<Py<PyAny>> {
    if b.as_constant() == Some(0.0) {
        return Err(PyZeroDivisionError::new_err("a formula is divided by zero"));
    }
    Ok(Py::new(py, PyExpr::of(Expr::unary(Unary::Floor, a / b)))?.into_any())
}

fn made(py: Python<'_>, op: Binary, a: Expr, b: Expr) -> PyResult<Py<PyAny>> {
    if matches!(op, Binary::Div | Binary::Mod) && b.as_constant() == Some(0.0) {
        return Err(PyZeroDivisionError::new_err("a formula is divided by zero"));
    }
    Ok(Py::new(py, PyExpr::of(Expr::binary(op, a, b)))?.into_any())
}

/// Where `a` is at least `b`.
fn at_least(py: Python<'_>, a: Expr, b: Expr) -> PyResult<Py<PyAny>> {
    let zero = |e: &Expr| e.as_constant() == Some(0.0);
    let condition = if zero(&b) { a } else { a - b };
    Ok(Py::new(py, PySolid::where_positive(condition))?.into_any())
}

#[pymethods]
impl PyExpr {
    fn __add__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Add, false)
    }
    fn __radd__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Add, true)
    }
    fn __sub__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Sub, false)
    }
    fn __rsub__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Sub, true)
    }
    fn __mul__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Mul, false)
    }
    fn __rmul__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Mul, true)
    }
    fn __truediv__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Div, false)
    }
    fn __rtruediv__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Div, true)
    }
    fn __pow__(
        &self,
        py: Python<'_>,
        other: &Bound<'_, PyAny>,
        modulo: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        match modulo {
            None => two(py, &self.expr, other, Binary::Pow, false),
            Some(_) => Ok(py.NotImplemented()),
        }
    }
    fn __rpow__(
        &self,
        py: Python<'_>,
        other: &Bound<'_, PyAny>,
        modulo: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        match modulo {
            None => two(py, &self.expr, other, Binary::Pow, true),
            Some(_) => Ok(py.NotImplemented()),
        }
    }
    fn __mod__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Mod, false)
    }
    fn __rmod__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        two(py, &self.expr, other, Binary::Mod, true)
    }
    fn __floordiv__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let Some(b) = formula(other) else { return Ok(py.NotImplemented()) };
        quotient(py, self.expr.clone(), b)
    }
    fn __rfloordiv__(&self, py: Python<'_>, other: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
        let Some(a) = formula(other) else { return Ok(py.NotImplemented()) };
        quotient(py, a, self.expr.clone())
    }
    fn __floor__(&self) -> Self {
        self.with(Unary::Floor)
    }
    fn __ceil__(&self) -> Self {
        Self::of(self.expr.clone().ceil())
    }
    fn __trunc__(&self) -> Self {
        Self::of(self.expr.clone().trunc())
    }
    fn __round__(&self) -> Self {
        Self::of(self.expr.clone().round())
    }
    fn __neg__(&self) -> Self {
        self.with(Unary::Neg)
    }
    fn __pos__(&self) -> Self {
        self.clone()
    }
    fn __abs__(&self) -> Self {
        self.with(Unary::Abs)
    }

    // What numpy calls for arrays of objects.
    /// The square root; what `numpy.sqrt` calls.
    fn sqrt(&self) -> Self {
        self.with(Unary::Sqrt)
    }
    /// e to this power.
    fn exp(&self) -> Self {
        self.with(Unary::Exp)
    }
    /// The natural logarithm.
    fn log(&self) -> Self {
        self.with(Unary::Log)
    }
    /// The sine of an angle in radians.
    fn sin(&self) -> Self {
        self.with(Unary::Sin)
    }
    /// The cosine of an angle in radians.
    fn cos(&self) -> Self {
        self.with(Unary::Cos)
    }
    /// The tangent of an angle in radians.
    fn tan(&self) -> Self {
        self.with(Unary::Tan)
    }
    /// The angle with this sine, in radians.
    fn arcsin(&self) -> Self {
        self.with(Unary::Asin)
    }
    /// The angle with this cosine, in radians.
    fn arccos(&self) -> Self {
        self.with(Unary::Acos)
    }
    /// The angle with this tangent, in radians.
    fn arctan(&self) -> Self {
        Self::of(Expr::binary(Binary::Atan2, self.expr.clone(), Expr::constant(1.0)))
    }
    /// The hyperbolic sine.
    fn sinh(&self) -> Self {
        self.with(Unary::Sinh)
    }
    /// The hyperbolic cosine.
    fn cosh(&self) -> Self {
        self.with(Unary::Cosh)
    }
    /// The hyperbolic tangent.
    fn tanh(&self) -> Self {
        self.with(Unary::Tanh)
    }
    /// The next whole number below.
    fn floor(&self) -> Self {
        self.with(Unary::Floor)
    }
    /// The next whole number above.
    fn ceil(&self) -> Self {
        self.__ceil__()
    }
    /// The whole number next to it towards 0.
    fn trunc(&self) -> Self {
        self.__trunc__()
    }
    /// The nearest whole number; halves go to the even one.
    fn rint(&self) -> Self {
        self.__round__()
    }

    fn __richcmp__(&self, py: Python<'_>, other: &Bound<'_, PyAny>, op: CompareOp) -> PyResult<Py<PyAny>> {
        let Some(b) = formula(other) else { return Ok(py.NotImplemented()) };
        let a = self.expr.clone();
        match op {
            CompareOp::Ge | CompareOp::Gt => at_least(py, a, b),
            CompareOp::Le | CompareOp::Lt => at_least(py, b, a),
            _ => Err(PyTypeError::new_err("formulas are compared by >= <= > <")),
        }
    }

    fn __bool__(&self) -> PyResult<bool> {
        Err(PyTypeError::new_err("a formula in x, y, z is neither true nor false; numpy.where chooses between two"))
    }

    fn __repr__(&self) -> String {
        "<rvachev.Expr: a formula in x, y, z>".into()
    }

    #[pyo3(signature = (ufunc, method, *inputs, **kwargs))]
    fn __array_ufunc__(
        &self,
        py: Python<'_>,
        ufunc: &Bound<'_, PyAny>,
        method: &str,
        inputs: &Bound<'_, PyTuple>,
        kwargs: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Py<PyAny>> {
        if method != "__call__" || kwargs.is_some_and(|k| !k.is_empty()) {
            return Ok(py.NotImplemented());
        }
        if inputs.iter().any(|v| v.cast::<PyUntypedArray>().is_ok_and(|a| a.ndim() > 0)) {
            return each(py, ufunc, inputs);
        }
        let Some(all) = inputs.iter().map(|v| formula(&v)).collect::<Option<Vec<Expr>>>() else {
            return Ok(py.NotImplemented());
        };
        let name: String = ufunc.getattr("__name__")?.extract()?;
        apply(py, &name, all)
    }

    #[pyo3(signature = (function, types, args, kwargs))]
    fn __array_function__(
        &self,
        py: Python<'_>,
        function: &Bound<'_, PyAny>,
        types: &Bound<'_, PyAny>,
        args: &Bound<'_, PyTuple>,
        kwargs: &Bound<'_, PyDict>,
    ) -> PyResult<Py<PyAny>> {
        let _ = types;
        array_function(py, function, args, kwargs)
    }
}

/// A function of numpy on an array of formulas, one by one.
fn each(py: Python<'_>, ufunc: &Bound<'_, PyAny>, inputs: &Bound<'_, PyTuple>) -> PyResult<Py<PyAny>> {
    let wrapped = inputs.iter().map(|v| {
        if v.cast::<PyExpr>().is_err() {
            return Ok(v);
        }
        let holder = PyArrayDyn::<Py<PyAny>>::from_owned_array(py, numpy::ndarray::arr0(v.unbind()).into_dyn());
        Ok(holder.into_any())
    });
    let wrapped = wrapped.collect::<PyResult<Vec<_>>>()?;
    Ok(ufunc.call1(PyTuple::new(py, wrapped)?)?.unbind())
}

fn apply(py: Python<'_>, name: &str, all: Vec<Expr>) -> PyResult<Py<PyAny>> {
    let expr = |e: Expr| Ok(Py::new(py, PyExpr::of(e))?.into_any());
    match &all[..] {
        [a] => {
            let a = a.clone();
            let unary = |op| expr(Expr::unary(op, a.clone()));
            match name {
                "negative" => unary(Unary::Neg),
                "positive" | "conjugate" => expr(a),
                "absolute" | "fabs" => unary(Unary::Abs),
                "sqrt" => unary(Unary::Sqrt),
                "exp" => unary(Unary::Exp),
                "log" => unary(Unary::Log),
                "log2" => expr(Expr::unary(Unary::Log, a) / std::f64::consts::LN_2),
                "log10" => expr(Expr::unary(Unary::Log, a) / std::f64::consts::LN_10),
                "sin" => unary(Unary::Sin),
                "cos" => unary(Unary::Cos),
                "tan" => unary(Unary::Tan),
                "arcsin" => unary(Unary::Asin),
                "arccos" => unary(Unary::Acos),
                "sinh" => unary(Unary::Sinh),
                "cosh" => unary(Unary::Cosh),
                "tanh" => unary(Unary::Tanh),
                "floor" => unary(Unary::Floor),
                "ceil" => expr(a.ceil()),
                "trunc" => expr(a.trunc()),
                "rint" => expr(a.round()),
                "sign" => unary(Unary::Sign),
                "arctan" => made(py, Binary::Atan2, a, Expr::constant(1.0)),
                "square" => made(py, Binary::Pow, a, Expr::constant(2.0)),
                "reciprocal" => made(py, Binary::Div, Expr::constant(1.0), a),
                "radians" | "deg2rad" => expr(a * (std::f64::consts::PI / 180.0)),
                "degrees" | "rad2deg" => expr(a * (180.0 / std::f64::consts::PI)),
                _ => Ok(py.NotImplemented()),
            }
        }
        [a, b] => {
            let (a, b) = (a.clone(), b.clone());
            let op = match name {
                "add" => Binary::Add,
                "subtract" => Binary::Sub,
                "multiply" => Binary::Mul,
                "divide" | "true_divide" => Binary::Div,
                "power" | "float_power" => Binary::Pow,
                "minimum" | "fmin" => Binary::Min,
                "maximum" | "fmax" => Binary::Max,
                "hypot" => Binary::Hypot,
                "arctan2" => Binary::Atan2,
                // np.mod is another name of it.
                "remainder" => Binary::Mod,
                "fmod" => return expr(a.fmod(b)),
                "floor_divide" => return quotient(py, a, b),
                "greater" | "greater_equal" => return at_least(py, a, b),
                "less" | "less_equal" => return at_least(py, b, a),
                _ => return Ok(py.NotImplemented()),
            };
            made(py, op, a, b)
        }
        _ => Ok(py.NotImplemented()),
    }
}

/// `numpy.where`, `numpy.clip` and `numpy.round`.
pub fn array_function(
    py: Python<'_>,
    function: &Bound<'_, PyAny>,
    args: &Bound<'_, PyTuple>,
    kwargs: &Bound<'_, PyDict>,
) -> PyResult<Py<PyAny>> {
    let name: String = function.getattr("__name__")?.extract()?;
    let all: Vec<Bound<'_, PyAny>> = args.iter().collect();
    if let (true, "round" | "around", [one]) = (kwargs.is_empty(), name.as_str(), &all[..])
        && let Some(e) = formula(one)
    {
        return Ok(Py::new(py, PyExpr::of(e.round()))?.into_any());
    }
    if let (true, [first, a, b]) = (kwargs.is_empty(), &all[..])
        && let (Some(a), Some(b)) = (formula(a), formula(b))
    {
        let condition = first.cast::<PySolid>().ok().and_then(|s| s.get().condition.clone());
        match (name.as_str(), condition, formula(first)) {
            ("where", Some(c), _) => return Ok(Py::new(py, PyExpr::of(Expr::select(c, a, b)))?.into_any()),
            ("clip", _, Some(e)) => {
                let above = Expr::binary(Binary::Max, e, a);
                return made(py, Binary::Min, above, b);
            }
            _ => {}
        }
    }
    Ok(py.NotImplemented())
}
