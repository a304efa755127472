// The emulator at the other end of a socket: asks for each access, and lends its memory.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "chip/chip.hpp"
#include "chip/wire.hpp"

namespace stator::chip {

class Emulator : public Memory {
  public:
    // Waits until it has connected. Throws std::system_error.
    explicit Emulator(const std::string& path);
    ~Emulator() override;

    // Answers until the emulated time `end_ns`, or until the emulator ends by itself. Throws
    // `Violation`, and lets the emulator say where the processor was.
    void serve(Chip& chip, uint64_t end_ns);
    uint64_t accesses() const { return accesses_; }
    unsigned resets() const { return resets_; }

    void fetch(uint32_t address, std::span<uint8_t> bytes) override;
    void store(uint32_t address, std::span<const uint8_t> bytes) override;

  private:
    bool take(void* bytes, size_t count) const;
    void give(const void* bytes, size_t count) const;
    wire::Reply answer(Chip& chip, const wire::Request& request);

    int socket_ = -1;
    uint64_t accesses_ = 0;
    unsigned resets_ = 0;
    bool has_started_ = false;
};

}  // namespace stator::chip
