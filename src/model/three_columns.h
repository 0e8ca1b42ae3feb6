#pragma once
// 3 × 3 matrices as columns of four numbers, the last of which is not used, for functions that are PISTE_WIDE.

#include <cstddef>
#include <cstring>

#include "math/four.h"
#include "piste/math/so3.h"

namespace piste {

// No column alone is a value of a function: it would have another interface where a processor is not wide.
struct ThreeColumns {
  Four x, y, z;

  PISTE_INSIDE static ThreeColumns of(const Matrix3d& M) {
    const double* m = M.data();
    return {Four{m[0], m[1], m[2], 0}, Four{m[3], m[4], m[5], 0}, Four{m[6], m[7], m[8], 0}};
  }
  PISTE_INSIDE static ThreeColumns diagonal(double d) { return {Four{d, 0, 0, 0}, Four{0, d, 0, 0}, Four{0, 0, d, 0}}; }
  /// [v×]
  PISTE_INSIDE static ThreeColumns skew(const Vector3d& v) {
    return {Four{0, v.z(), -v.y(), 0}, Four{-v.z(), 0, v.x(), 0}, Four{v.y(), -v.x(), 0, 0}};
  }
  /// [a×] [b×] = b aᵀ − (a · b)
  PISTE_INSIDE static ThreeColumns skews(const Vector3d& a, const Vector3d& b) {
    const Four c{b.x(), b.y(), b.z(), 0};
    const ThreeColumns all{a.x() * c, a.y() * c, a.z() * c};
    return all - diagonal(a.x() * b.x() + a.y() * b.y() + a.z() * b.z());
  }

  PISTE_INSIDE ThreeColumns operator+(const ThreeColumns& o) const { return {x + o.x, y + o.y, z + o.z}; }
  PISTE_INSIDE ThreeColumns operator-(const ThreeColumns& o) const { return {x - o.x, y - o.y, z - o.z}; }
  PISTE_INSIDE friend ThreeColumns operator*(double f, const ThreeColumns& a) { return {f * a.x, f * a.y, f * a.z}; }
  PISTE_INSIDE ThreeColumns operator*(const ThreeColumns& o) const {
    return {x * o.x[0] + y * o.x[1] + z * o.x[2], x * o.y[0] + y * o.y[1] + z * o.y[2],
            x * o.z[0] + y * o.z[1] + z * o.z[2]};
  }
  /// Times the transpose of another.
  PISTE_INSIDE ThreeColumns times_transposed(const ThreeColumns& o) const {
    return {x * o.x[0] + y * o.y[0] + z * o.z[0], x * o.x[1] + y * o.y[1] + z * o.z[1],
            x * o.x[2] + y * o.y[2] + z * o.z[2]};
  }
  /// Times diag(d).
  PISTE_INSIDE ThreeColumns times_diagonal(const Vector3d& d) const { return {d.x() * x, d.y() * y, d.z() * z}; }
  /// Times [v×].
  PISTE_INSIDE ThreeColumns times_skew(const Vector3d& v) const {
    return {v.z() * y - v.y() * z, v.x() * z - v.z() * x, v.y() * x - v.x() * y};
  }
  /// [v×] times it.
  PISTE_INSIDE ThreeColumns turned_by(const Vector3d& v) const {
    const Four first{v.y(), v.z(), v.x(), 0}, second{v.z(), v.x(), v.y(), 0};
    ThreeColumns out;
    const Four* from[] = {&x, &y, &z};
    Four* to[] = {&out.x, &out.y, &out.z};
    for (int j = 0; j < 3; ++j) {
      const Four& a = *from[j];
      *to[j] = first * Four{a[2], a[0], a[1], 0} - second * Four{a[1], a[2], a[0], 0};
    }
    return out;
  }
  PISTE_INSIDE ThreeColumns transposed() const {
    return {Four{x[0], y[0], z[0], 0}, Four{x[1], y[1], z[1], 0}, Four{x[2], y[2], z[2], 0}};
  }

  /// Writes it among columns that are `stride` numbers apart.
  PISTE_INSIDE void put(double* to, std::ptrdiff_t stride) const {
    using Two = double __attribute__((vector_size(2 * sizeof(double))));
    const Four* columns[] = {&x, &y, &z};
    for (int j = 0; j < 3; ++j, to += stride) {
      const Four& c = *columns[j];
      const Two two{c[0], c[1]};
      std::memcpy(to, &two, sizeof two);
      to[2] = c[2];
    }
  }
};

}  // namespace piste
