// The true flight as a file.
#include "world/truth.hpp"

#include <bit>
#include <string>

namespace stator::world {

static_assert(std::endian::native == std::endian::little);

bool write_truth_head(std::FILE* file) {
    std::string line;
    for (const char* const column : kTruthColumns) line.append(column).append(" ");
    line.append((2 * sizeof(double) - 1 - line.size() % sizeof(double)) % sizeof(double), ' ');
    line.append("\n");
    return std::fwrite(line.data(), 1, line.size(), file) == line.size();
}

bool write_truth(std::FILE* file, const World& world) {
    const Plant& plant = world.plant();
    const QuadState& state = plant.state();
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
                                                       wind_N.z(),
                                                       state.rotor_speeds[0],
                                                       state.rotor_speeds[1],
                                                       state.rotor_speeds[2],
                                                       state.rotor_speeds[3],
                                                       battery.voltage(),
                                                       battery.current(),
                                                       battery.remaining()};
    return std::fwrite(row.data(), sizeof(double), row.size(), file) == row.size();
}

}  // namespace stator::world
