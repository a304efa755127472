// The mission of a simulated board, in a memory of the board.
#pragma once

#include "../mission_driver.hpp"
#include "mission_sim_sample.hpp"
#include "stator/newest.hpp"

namespace stator::drivers::mission::sim {

class MissionSim {
  public:
    // The board puts its functions here, which say whether they did it all; without them the memory
    // counts as empty. The world says whether it is lost.
    struct Device {
        bool (*read)(uint32_t address, std::span<uint8_t> bytes) = nullptr;
        bool (*write)(uint32_t address, std::span<const uint8_t> bytes) = nullptr;
        Newest<MissionSimSample> state{};

        void put(const MissionSimSample& sample) { state.put(sample); }
    };
    struct Port {
        bool read(uint32_t address, std::span<uint8_t> bytes) const;
        bool write(uint32_t address, std::span<const uint8_t> bytes) const;
        Device& device;
    };

    explicit MissionSim(Device& device) : device_(device), driver_(Port{device}) {}
    void step(MissionPorts& ports) { driver_.step(ports, device_.state.get().value.is_lost); }

  private:
    Device& device_;
    MissionDriver<Port> driver_;
};

}  // namespace stator::drivers::mission::sim
