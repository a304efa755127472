// The nonvolatile memory of a simulated board.
#pragma once

#include "../nonvolatile_driver.hpp"

namespace stator::drivers::nonvolatile::sim {

class NonvolatileSim {
  public:
    // The board puts its functions here, which say whether they did it all; without them, loading
    // fails, as with no memory on the bus.
    struct Device {
        bool (*read)(uint32_t address, std::span<uint8_t> bytes) = nullptr;
        bool (*write)(uint32_t address, std::span<const uint8_t> bytes) = nullptr;
        mav::SharedKey* key = nullptr;  // of the lines; null: nobody asks for it
    };
    struct Port {
        bool read(uint32_t address, std::span<uint8_t> bytes) const;
        bool write(uint32_t address, std::span<const uint8_t> bytes) const;
        Device& device;
    };
    static constexpr uint32_t kBytes = RecordStore<Port>::kBytes;

    explicit NonvolatileSim(Device& device) : device_(device), driver_(Port{device}) {}
    void step(NonvolatilePorts& ports) { driver_.step(ports, device_.key); }

  private:
    Device& device_;
    NonvolatileDriver<Port> driver_;
};

}  // namespace stator::drivers::nonvolatile::sim
