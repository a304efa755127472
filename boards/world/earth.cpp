// Where on Earth the simulated world lies.
#include "world/earth.hpp"

namespace stator::world {

namespace {

// WGS 84: semi-major axis, and first eccentricity squared.
constexpr double kSemiMajorAxis = 6378137.0;  // m
constexpr double kEccentricity2 = 6.69437999014e-3;

// ISO 2533 up to 11 km.
constexpr double kSeaTemperature = 288.15;  // K
constexpr double kLapse = 0.0065;           // K/m
constexpr double kPressureExponent = 5.255880;
constexpr double kZeroCelsius = 273.15;     // K
constexpr double kGasConstant = 287.05287;  // J/(kg K), of dry air

constexpr double radians(double degrees) {
    return degrees * (math::kPi<double> / 180.0);
}

}  // namespace

Geodetic Earth::geodetic(const Vector3& position_N) const {
    const auto [sin, cos] = math::sincos(radians(latitude_deg));
    const double height = altitude_msl - position_N.z();
    const double ellipsoid = altitude_msl + geoid;
    const double w2 = 1.0 - kEccentricity2 * sin * sin;
    const double east_west = kSemiMajorAxis / math::sqrt(w2);
    const double north_south = east_west * (1.0 - kEccentricity2) / w2;
    const double degrees = 180.0 / math::kPi<double>;
    return {
        .latitude_deg = latitude_deg + degrees * position_N.x() / (north_south + ellipsoid),
        .longitude_deg = longitude_deg + degrees * position_N.y() / ((east_west + ellipsoid) * cos),
        .altitude_msl = height,
        .altitude_ellipsoid = height + geoid};
}

double Earth::pressure(double height) const {
    const double ratio = 1.0 - kLapse * (altitude_msl + height) / kSeaTemperature;
    return sea_pressure * math::pow(ratio, kPressureExponent);
}

double Earth::temperature_degc(double height) const {
    return kSeaTemperature - kLapse * (altitude_msl + height) - kZeroCelsius;
}

double Earth::density(double height) const {
    return pressure(height) / (kGasConstant * (temperature_degc(height) + kZeroCelsius));
}

Vector3 Earth::magnetic_field_N() const {
    const auto declination = math::sincos(radians(declination_deg));
    const auto inclination = math::sincos(radians(inclination_deg));
    return field_gauss * Vector3(inclination.cos * declination.cos,
                                 inclination.cos * declination.sin, inclination.sin);
}

}  // namespace stator::world
