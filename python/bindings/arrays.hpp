#pragma once
// NumPy arrays at the border: shapes and integer types are checked here once, views go out read-only.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <initializer_list>
#include <string>

#include "plica/core/block_matrix.hpp"
#include "plica/core/error.hpp"
#include "plica/core/types.hpp"

namespace plica::python {

namespace py = pybind11;

using RealArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using IntArray = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

/// "(n, 3)" of what came in.
inline std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t k = 0; k < array.ndim(); ++k) {
    text += (k ? ", " : "") + std::to_string(array.shape(k));
  }
  return text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] inline void wrong_shape(const std::string& where, const std::string& name, const py::array& array,
                                     const std::string& wanted) {
  throw InvalidInput(where + ": " + name + " has shape " + shape_text(array) + "; must be " + wanted + ".");
}

/// (n, 3) positions, displacements, ...
inline Points to_points(const RealArray& array, const std::string& where, const std::string& name) {
  if (array.ndim() != 2 || array.shape(1) != 3) {
    wrong_shape(where, name, array, "(n, 3)");
  }
  return Eigen::Map<const Points>(array.data(), array.shape(0), 3);
}

/// Whole numbers of any NumPy type; floating-point arrays are refused, not truncated. An empty list passes.
inline IntArray to_integers(const py::array& array, const std::string& where, const std::string& name) {
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u' && array.size() > 0) {
    throw InvalidInput(where + ": " + name + " has type " + std::string(py::str(array.dtype())) +
                       "; must be whole numbers.");
  }
  return IntArray(array);
}

/// (rows, one of the widths) node numbers.
inline Cells to_rows(const py::array& array, std::initializer_list<int> widths, const std::string& where,
                     const std::string& name) {
  const IntArray numbers = to_integers(array, where, name);
  std::string wanted;
  for (const int width : widths) {
    wanted += (wanted.empty() ? "(m, " : " or (m, ") + std::to_string(width) + ")";
    if (numbers.ndim() == 2 && numbers.shape(1) == width) {
      return Eigen::Map<const Cells>(numbers.data(), numbers.shape(0), width);
    }
  }
  wrong_shape(where, name, array, wanted);
}

inline Indices to_indices(const py::array& array, const std::string& where, const std::string& name) {
  const IntArray numbers = to_integers(array, where, name);
  if (numbers.ndim() != 1) {
    wrong_shape(where, name, array, "(k,)");
  }
  return Eigen::Map<const Indices>(numbers.data(), numbers.size());
}

/// Throws where a row names a node that is not below `nodes`.
template <typename Rows>
void check_nodes(const Rows& rows, std::ptrdiff_t nodes, const std::string& where, const std::string& name) {
  for (std::ptrdiff_t row = 0; row < rows.rows(); ++row) {
    for (std::ptrdiff_t k = 0; k < rows.cols(); ++k) {
      if (rows(row, k) < 0 || rows(row, k) >= nodes) {
        throw InvalidInput(where + ": " + name + " " + std::to_string(row) + " names node " +
                           std::to_string(rows(row, k)) + "; must be in [0, " + std::to_string(nodes) + ").");
      }
    }
  }
}

/// Read-only view of a dense row-major matrix that `owner` keeps alive.
template <typename Matrix>
py::array_t<typename Matrix::Scalar> view(const Matrix& matrix, const py::handle& owner) {
  using Scalar = typename Matrix::Scalar;
  std::vector<py::ssize_t> shape{matrix.rows()};
  if (Matrix::ColsAtCompileTime != 1) {
    shape.push_back(matrix.cols());
  }
  py::array_t<Scalar> array(shape, matrix.data(), owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// A computed matrix handed over without a copy; its memory lives as long as the array.
template <typename Matrix>
py::array_t<typename Matrix::Scalar> give(Matrix matrix) {
  using Scalar = typename Matrix::Scalar;
  auto* kept = new Matrix(std::move(matrix));
  const py::capsule owner(kept, [](void* pointer) { delete static_cast<Matrix*>(pointer); });
  std::vector<py::ssize_t> shape{kept->rows()};
  if (Matrix::ColsAtCompileTime != 1) {
    shape.push_back(kept->cols());
  }
  return py::array_t<Scalar>(shape, kept->data(), owner);
}

/// (data, indices, indptr) as scipy.sparse.csr_array takes them.
using Csr = py::typing::Tuple<py::array_t<double>, py::array_t<std::int32_t>, py::array_t<std::int32_t>>;

inline Csr give_csr(SparseMatrix matrix) {
  matrix.makeCompressed();
  auto* kept = new SparseMatrix(std::move(matrix));
  const py::capsule owner(kept, [](void* pointer) { delete static_cast<SparseMatrix*>(pointer); });
  return py::make_tuple(py::array_t<double>(kept->nonZeros(), kept->valuePtr(), owner),
                        py::array_t<std::int32_t>(kept->nonZeros(), kept->innerIndexPtr(), owner),
                        py::array_t<std::int32_t>(kept->outerSize() + 1, kept->outerIndexPtr(), owner));
}

}  // namespace plica::python
