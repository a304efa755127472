// The local frame against exact coordinates: from the ellipsoid to the Earth's centre and back to
// the plane that touches it at the origin.
#include "stator/geodesy.hpp"

#include <gtest/gtest.h>

#include "stator/rotation.hpp"

namespace stator::math {
namespace {

using Point = Vector3<double>;

constexpr double kDegree = kPi<double> / 180;

Point earth_centred(const LatitudeLongitude& at) {
    constexpr double kE2 = 6.69437999014e-3;  // WGS 84
    const auto [sin_lat, cos_lat] = sincos(at.latitude_deg * kDegree);
    const auto [sin_lon, cos_lon] = sincos(at.longitude_deg * kDegree);
    const double n = 6378137.0 / sqrt(1 - kE2 * sin_lat * sin_lat);
    return {n * cos_lat * cos_lon, n * cos_lat * sin_lon, n * (1 - kE2) * sin_lat};
}

NorthEast exact(const LatitudeLongitude& origin, const LatitudeLongitude& at) {
    const Point d = earth_centred(at) - earth_centred(origin);
    const auto [sin_lat, cos_lat] = sincos(origin.latitude_deg * kDegree);
    const auto [sin_lon, cos_lon] = sincos(origin.longitude_deg * kDegree);
    return {-sin_lat * cos_lon * d.x() - sin_lat * sin_lon * d.y() + cos_lat * d.z(),
            -sin_lon * d.x() + cos_lon * d.y()};
}

class Geodesy : public ::testing::TestWithParam<LatitudeLongitude> {};

TEST_P(Geodesy, IsExactToDecimetresAtTenKilometres) {
    const LatitudeLongitude origin = GetParam();
    const LocalFrame frame(origin);
    for (const double north : {-10e3, 0.0, 3.0, 10e3}) {
        for (const double east : {-10e3, -2.0, 0.0, 10e3}) {
            const LatitudeLongitude at = frame.from_local({north, east});
            const NorthEast truth = exact(origin, at);
            EXPECT_NEAR(truth.north, north, 0.2);
            EXPECT_NEAR(truth.east, east, 0.2);
            const NorthEast back = frame.to_local(at);
            EXPECT_NEAR(back.north, north, 1e-6);
            EXPECT_NEAR(back.east, east, 1e-6);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Places, Geodesy,
                         ::testing::Values(LatitudeLongitude{47.4, 8.5},
                                           LatitudeLongitude{-37.9, 144.8},
                                           LatitudeLongitude{0.0, 179.99},
                                           LatitudeLongitude{60.0, -180.0}));

}  // namespace
}  // namespace stator::math
