#include "arrays.hpp"
#include "engine.hpp"
#include "plica/core/error.hpp"
#include "plica/estimation/covariance.hpp"

using namespace plica;
using namespace plica::estimation;
using namespace plica::python;

namespace {

using Released = py::gil_scoped_release;
using Array = py::array_t<double>;  // of any strides: a transposed array is taken as it lies

constexpr py::ssize_t real = sizeof(double);

void check_matrix(const Array& array, const std::string& where, const std::string& name) {
  if (array.ndim() != 2) wrong_shape(where, name, array, "(rows, columns)");
  if (array.size() > 0 && (array.strides(0) % real != 0 || array.strides(1) % real != 0)) {
    throw InvalidInput(where + ": " + name +
                       " does not lie on a grid of 8 bytes; must, as every copy of it does.");
  }
}

void check_shape(const Array& array, std::ptrdiff_t rows, std::ptrdiff_t columns, const std::string& where,
                 const std::string& name) {
  check_matrix(array, where, name);
  if (array.shape(0) != rows || array.shape(1) != columns) {
    wrong_shape(where, name, array, "(" + std::to_string(rows) + ", " + std::to_string(columns) + ")");
  }
}

MatrixView view_of(const Array& array) {
  return {array.data(), array.shape(0), array.shape(1), array.strides(0) / real, array.strides(1) / real};
}

/// What is written in place: rows that lie contiguous.
MatrixSpan span_of(Array& array, const std::string& where, const std::string& name) {
  if (array.size() > 0 && array.shape(1) > 1 && array.strides(1) != real) {
    throw InvalidInput(where + ": " + name +
                       " is not contiguous along its rows; must be, since it is written in place.");
  }
  return {array.mutable_data(), array.shape(0), array.shape(1), array.strides(0) / real, 1};
}

void copy_upper(const MatrixView& from, const MatrixSpan& to) {
  for (std::ptrdiff_t i = 0; i < from.rows; ++i) {
    for (std::ptrdiff_t j = i; j < from.rows; ++j) {
      to.data[i * to.row_stride + j] = from.data[i * from.row_stride + j * from.column_stride];
    }
  }
}

Array product(const Array& a, const Array& b) {
  check_matrix(a, "product", "a");
  check_matrix(b, "product", "b");
  check_shape(b, a.shape(1), b.shape(1), "product", "b");
  Array c({a.shape(0), b.shape(1)});
  const MatrixSpan out = span_of(c, "product", "out");
  const Released released;
  multiply(1.0, view_of(a), view_of(b), out, Part::full, Into::overwrite);
  return c;
}

}  // namespace

void bind_estimation(py::module_& engine) {
  engine.def("product", &product, py::arg("a"), py::arg("b"));
  engine.def(
      "symmetric_product",
      [](const Array& a, const Array& b) {
        const char* where = "symmetric_product";
        check_matrix(a, where, "a");
        check_shape(b, a.shape(1), a.shape(0), where, "b");
        Array c({a.shape(0), a.shape(0)});
        const MatrixSpan out = span_of(c, where, "out");
        {
          const Released released;
          symmetric_product(view_of(a), view_of(b), out, Into::overwrite);
        }
        return c;
      },
      py::arg("a"), py::arg("b"));
  engine.def(
      "congruence",
      [](const Array& g, const Array& p, const Array& plus) {
        const char* where = "congruence";
        check_matrix(g, where, "g");
        check_shape(p, g.shape(1), g.shape(1), where, "p");
        check_shape(plus, g.shape(0), g.shape(0), where, "plus");
        Array c({g.shape(0), g.shape(0)});
        const MatrixSpan out = span_of(c, where, "out");
        {
          const Released released;
          copy_upper(view_of(plus), out);
          congruence(view_of(g), view_of(p), out, Into::add);
        }
        return c;
      },
      py::arg("g"), py::arg("p"), py::arg("plus"));
  engine.def(
      "gram_update",
      [](Array p, const Array& w, double scale) {
        const char* where = "gram_update";
        check_matrix(w, where, "w");
        check_shape(p, w.shape(1), w.shape(1), where, "p");
        const MatrixSpan out = span_of(p, where, "p");
        const Released released;
        gram_update(scale, view_of(w), out);
      },
      py::arg("p").noconvert(), py::arg("w"), py::arg("scale"));
  engine.def(
      "cholesky",
      [](const Array& a) {
        const char* where = "cholesky";
        check_matrix(a, where, "a");
        check_shape(a, a.shape(0), a.shape(0), where, "a");
        const MatrixView from = view_of(a);
        Array r({a.shape(0), a.shape(0)});
        const MatrixSpan out = span_of(r, where, "out");
        std::ptrdiff_t done = 0;
        {
          const Released released;
          copy_upper(from, out);
          done = cholesky(out);
        }
        if (done < from.rows) {
          throw SolveFailed("cholesky: the pivot of row " + std::to_string(done) + " of " +
                            std::to_string(from.rows) + " is not > 0; the matrix must be positive definite.");
        }
        return r;
      },
      py::arg("a"));
  const auto solve = [&engine](const char* name, void (*solve)(const MatrixView&, const MatrixSpan&)) {
    engine.def(
        name,
        [name, solve](const Array& r, Array x) {
          check_matrix(r, name, "r");
          check_shape(r, r.shape(0), r.shape(0), name, "r");
          check_matrix(x, name, "x");
          check_shape(x, r.shape(0), x.shape(1), name, "x");
          if (r.size() > 0 && r.shape(0) > 1 && r.strides(1) != real) {
            throw InvalidInput(std::string(name) + ": r is not contiguous along its rows; must be.");
          }
          const MatrixSpan out = span_of(x, name, "x");
          const Released released;
          solve(view_of(r), out);
        },
        py::arg("r"), py::arg("x").noconvert());
  };
  solve("solve_lower", &solve_lower);
  solve("solve_upper", &solve_upper);
}
