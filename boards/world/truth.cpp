// The true flight as a file.
#include "world/truth.hpp"

#include <bit>
#include <span>
#include <string>

namespace stator::world {

static_assert(std::endian::native == std::endian::little);

namespace {

bool write(std::FILE* file, std::span<const double> values) {
    return std::fwrite(values.data(), sizeof(double), values.size(), file) == values.size();
}

}  // namespace

bool write_truth_head(std::FILE* file, const World& world) {
    std::string line;
    for (const char* const column : kTruthColumns) line.append(column).append(" ");
    for (unsigned i = 0; i < world.vehicle().airframe.rotor_count(); ++i) {
        line.append("rotor_").append(std::to_string(i + 1)).append(" ");
    }
    const Airframe& airframe = world.vehicle().airframe;
    for (unsigned i = 0; i < airframe.propellers.size(); ++i) {
        line.append("propeller_").append(std::to_string(i + 1)).append(" ");
    }
    for (unsigned i = 0; i < airframe.wing.surfaces.size(); ++i) {
        line.append("surface_").append(std::to_string(i + 1)).append(" ");
    }
    for (const char* const column : kBatteryColumns) line.append(column).append(" ");
    line.append((2 * sizeof(double) - 1 - line.size() % sizeof(double)) % sizeof(double), ' ');
    line.append("\n");
    return std::fwrite(line.data(), 1, line.size(), file) == line.size();
}

bool write_truth(std::FILE* file, const World& world) {
    const Plant& plant = world.plant();
    const VehicleState& state = plant.state();
    const Vector3& wind_N = world.influence().wind_N;
    const Battery& battery = world.battery();
    const std::array<double, kTruthColumns.size()> row{static_cast<double>(plant.time_us()),
                                                       state.position_N.x(),
                                                       state.position_N.y(),
                                                       state.position_N.z(),
                                                       state.velocity_N.x(),
                                                       state.velocity_N.y(),
                                                       state.velocity_N.z(),
                                                       state.q_NB.w(),
                                                       state.q_NB.x(),
                                                       state.q_NB.y(),
                                                       state.q_NB.z(),
                                                       state.rate_B.x(),
                                                       state.rate_B.y(),
                                                       state.rate_B.z(),
                                                       plant.is_on_ground() ? 1.0 : 0.0,
                                                       wind_N.x(),
                                                       wind_N.y(),
                                                       wind_N.z()};
    const std::array<double, kBatteryColumns.size()> last{battery.voltage(), battery.current(),
                                                          battery.remaining()};
    const Airframe& airframe = plant.parameters();
    return write(file, row) && write(file, {state.rotor_speeds.data(), airframe.rotor_count()}) &&
           write(file, {state.propeller_speeds.data(), airframe.propellers.size()}) &&
           write(file, {plant.deflections().data(), airframe.wing.surfaces.size()}) &&
           write(file, last);
}

}  // namespace stator::world
