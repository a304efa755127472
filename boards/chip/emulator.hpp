// The emulator at the other end of a socket: asks for each access, and lends its memory.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "chip/chip.hpp"
#include "chip/wire.hpp"

namespace stator::chip {

class Emulator : public Memory {
  public:
    // Waits until it has connected. Throws std::system_error.
    explicit Emulator(const std::string& path);
    ~Emulator() override;

    // Answers until `is_over`, or until the emulator ends by itself. Throws `Violation`, and lets
    // the emulator say where the processor was.
    void serve(Chip& chip, const std::function<bool()>& is_over);
    // Ends the emulator, which waits for its last answer since then.
    void stop();
    uint64_t requests() const { return requests_; }
    unsigned resets() const { return resets_; }

    void fetch(uint32_t address, std::span<uint8_t> bytes) override;
    void store(uint32_t address, std::span<const uint8_t> bytes) override;

  private:
    bool take(void* bytes, size_t count) const;
    void give(const wire::Reply& reply);
    void append(const void* bytes, size_t count);
    void flush_stored();
    wire::Reply answer(Chip& chip, const wire::Request& request);

    static constexpr size_t kMostStored = 65536;  // the machine's buffer

    int socket_ = -1;
    std::vector<uint8_t> unsent_;
    std::vector<uint8_t> stored_;  // up to `store_end_`; not yet in `unsent_`
    uint32_t store_end_ = 0;
    uint64_t requests_ = 0;
    unsigned resets_ = 0;
    bool has_started_ = false;
};

}  // namespace stator::chip
