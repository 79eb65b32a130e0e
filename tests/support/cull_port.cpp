// SPDX-License-Identifier: MIT
#include "support/cull_port.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace qs::test {
namespace {

constexpr int kTile = 16;

class Port {
 public:
  Port(const CullVector& vector, PortBug bug) : bug_(bug) {
    const double extra = bug == PortBug::dilated_twice ? 0.3 : 0;
    sxx_ = static_cast<double>(vector.footprint.covariance.xx) + extra;
    sxy_ = static_cast<double>(vector.footprint.covariance.xy);
    syy_ = static_cast<double>(vector.footprint.covariance.yy) + extra;
    const double shift = bug == PortBug::half_pixel ? 0.5 : 0;
    x_ = static_cast<double>(vector.footprint.mean_px.x) + shift;
    y_ = static_cast<double>(vector.footprint.mean_px.y) + shift;
    determinant_ = sxx_ * syy_ - sxy_ * sxy_;
    a_ = syy_ / determinant_;
    b_ = -sxy_ / determinant_;
    c_ = sxx_ / determinant_;
    if (bug == PortBug::swapped_conic) std::swap(a_, c_);
    const double factor = bug == PortBug::no_factor_two ? 1 : 2;
    gamma_ = factor * std::log(255 * static_cast<double>(vector.opacity));
    if (bug == PortBug::three_sigma) gamma_ = 9;
    if (bug == PortBug::faint_kept) gamma_ = std::abs(gamma_);
    columns_ = (vector.width + kTile - 1) / kTile;
    rows_ = (vector.height + kTile - 1) / kTile;
    whole_columns_ = bug == PortBug::partial_tile ? vector.width / kTile : columns_;
    whole_rows_ = bug == PortBug::partial_tile ? vector.height / kTile : rows_;
  }

  std::set<int> tiles(const std::string& mode) const {
    if (mode == "3dgs") return square();
    if (gamma_ <= 0) return {};
    if (mode == "adr")
      return box(x_ - half().first, x_ + half().first, y_ - half().second, y_ + half().second);
    if (mode == "exact") return exact();
    return quadrants(mode == "quadbox");
  }

 private:
  int index(int column, int row) const {
    return bug_ == PortBug::columns_first ? column * rows_ + row : row * columns_ + column;
  }

  std::pair<double, double> half() const {
    if (bug_ == PortBug::larger_radius) {
      const double r = std::ceil(std::sqrt(gamma_ * larger_eigenvalue()));
      return {r, r};
    }
    const double of_conic = a_ * c_ - b_ * b_;
    return {std::sqrt(gamma_ * c_ / of_conic), std::sqrt(gamma_ * a_ / of_conic)};
  }

  double larger_eigenvalue() const {
    const double mid = (sxx_ + syy_) / 2;
    return mid + std::sqrt(std::max(0.1, mid * mid - determinant_));
  }

  std::pair<int, int> run(double low, double high, int limit) const {
    int begin = static_cast<int>(std::floor(low / kTile));
    int end = static_cast<int>(std::ceil(high / kTile));
    if (bug_ == PortBug::last_tile) end = static_cast<int>(std::floor(high / kTile));
    if (bug_ == PortBug::truncated) end = static_cast<int>(high / kTile) + 1;
    return {std::clamp(begin, 0, limit), std::clamp(end, 0, limit)};
  }

  std::set<int> box(double left, double right, double top, double bottom) const {
    const auto [c0, c1] = run(left, right, columns_);
    const auto [r0, r1] = run(top, bottom, rows_);
    return where([&, c0 = c0, c1 = c1, r0 = r0, r1 = r1](int c, int r) {
      return c >= c0 && c < c1 && r >= r0 && r < r1;
    });
  }

  std::set<int> where(const std::function<bool(int, int)>& lists) const {
    std::set<int> tiles;
    for (int r = 0; r < whole_rows_; ++r)
      for (int c = 0; c < whole_columns_; ++c)
        if (lists(c, r)) tiles.insert(index(c, r));
    return tiles;
  }

  std::set<int> square() const {
    double radius = 3 * std::sqrt(larger_eigenvalue());
    if (bug_ != PortBug::square_not_ceiled) radius = std::ceil(radius);
    const auto of = [&](double mean, int limit) {
      return std::pair{std::clamp(static_cast<int>((mean - radius) / kTile), 0, limit),
                       std::clamp(static_cast<int>((mean + radius + kTile - 1) / kTile), 0, limit)};
    };
    const auto columns = of(x_, columns_), rows = of(y_, rows_);
    return where([&](int c, int r) {
      return c >= columns.first && c < columns.second && r >= rows.first && r < rows.second;
    });
  }

  std::set<int> quadrants(bool with_minor) const {
    const auto [x_max, y_max] = half();
    double f = std::sqrt(1 - b_ * b_ / (a_ * c_));
    if (bug_ == PortBug::no_root_of_f) f = f * f;
    const bool same_is_major = bug_ == PortBug::wrong_sign ? b_ >= 0 : b_ < 0;
    std::set<int> tiles;
    for (const int dx : {-1, 1}) {
      for (const int dy : {-1, 1}) {
        const bool is_major = (dx == dy) == same_is_major;
        if (!is_major && !with_minor) continue;
        const double x = is_major ? x_max : f * x_max, y = is_major ? y_max : f * y_max;
        tiles.merge(box(dx < 0 ? x_ - x : x_, dx < 0 ? x_ : x_ + x, dy < 0 ? y_ - y : y_,
                        dy < 0 ? y_ : y_ + y));
      }
    }
    return tiles;
  }

  double q(double x, double y) const {
    return a_ * x * x + (bug_ == PortBug::single_b ? 1 : 2) * b_ * x * y + c_ * y * y;
  }

  std::set<int> exact() const {
    const double last = bug_ == PortBug::borders ? kTile : kTile - 1;
    return where([&](int column, int row) {
      const double x0 = kTile * column - x_, x1 = x0 + last, y0 = kTile * row - y_, y1 = y0 + last;
      double smallest = std::min({q(x0, y0), q(x1, y0), q(x0, y1), q(x1, y1)});
      if (bug_ != PortBug::corners_only) {
        for (const double x : {x0, x1})
          smallest = std::min(smallest, q(x, std::clamp(-b_ * x / c_, y0, y1)));
        for (const double y : {y0, y1})
          smallest = std::min(smallest, q(std::clamp(-b_ * y / a_, x0, x1), y));
        if (x0 <= 0 && x1 >= 0 && y0 <= 0 && y1 >= 0) smallest = 0;
      }
      return smallest <= gamma_;
    });
  }

  PortBug bug_;
  double sxx_, sxy_, syy_, x_, y_, determinant_, a_, b_, c_, gamma_;
  int columns_, rows_, whole_columns_, whole_rows_;
};

}  // namespace

std::set<int> tiles_of_port(const std::string& mode, const CullVector& vector, PortBug bug) {
  return Port(vector, bug).tiles(mode);
}

}  // namespace qs::test
