// The centre of a sphere from points on it.
#include "sphere_fit.hpp"

#include <algorithm>

namespace stator::apps::calibration {

void SphereFit::add(const math::Vector3<float>& point) {
    if (count_ == 0) {
        first_ = least_ = most_ = point;
    } else if (math::norm(point - last_) < kApart) {
        return;
    }
    last_ = point;
    const math::Vector3<float> m = point - first_;
    const std::array<float, 4> row{2.0F * m.x(), 2.0F * m.y(), 2.0F * m.z(), 1.0F};
    const float square = m.dot(m);
    for (unsigned i = 0; i < 4; ++i) {
        for (unsigned j = 0; j < 4; ++j) sums_[i][j] += row[i] * row[j];
        sums_[i][4] += row[i] * square;
    }
    square_sum_ += square * square;
    for (int i = 0; i < 3; ++i) {
        least_[i] = math::min(least_[i], point[i]);
        most_[i] = math::max(most_[i], point[i]);
    }
    ++count_;
}

float SphereFit::coverage() const {
    const math::Vector3<float> span = most_ - least_;
    const float longest = math::max(math::max(span.x(), span.y()), span.z());
    const float shortest = math::min(math::min(span.x(), span.y()), span.z());
    return shortest / math::max(longest, kLeastSpan);
}

std::optional<SphereFit::Sphere> SphereFit::fit() const {
    if (count_ < 20) return {};
    auto a = sums_;
    std::array<float, 4> x{};
    for (unsigned i = 0; i < 4; ++i) {
        unsigned pivot = i;
        for (unsigned k = i + 1; k < 4; ++k) {
            if (math::abs(a[k][i]) > math::abs(a[pivot][i])) pivot = k;
        }
        std::swap(a[i], a[pivot]);
        if (!(math::abs(a[i][i]) > 1e-6F)) return {};
        for (unsigned k = i + 1; k < 4; ++k) {
            const float factor = a[k][i] / a[i][i];
            for (unsigned j = i; j < 5; ++j) a[k][j] -= factor * a[i][j];
        }
    }
    for (unsigned i = 4; i-- > 0;) {
        float rest = a[i][4];
        for (unsigned j = i + 1; j < 4; ++j) rest -= a[i][j] * x[j];
        x[i] = rest / a[i][i];
    }
    const math::Vector3<float> centre(x[0], x[1], x[2]);
    const float square = x[3] + centre.dot(centre);
    if (!(square > 0.0F)) return {};
    const float radius = math::sqrt(square);
    // What is left of the squares: each is 2 r times a distance from the sphere.
    float left = square_sum_;
    for (unsigned i = 0; i < 4; ++i) left -= x[i] * sums_[i][4];
    const float error =
        math::sqrt(math::max(left, 0.0F) / static_cast<float>(count_)) / (2.0F * radius);
    return Sphere{.centre = centre + first_, .radius = radius, .error = error};
}

}  // namespace stator::apps::calibration
