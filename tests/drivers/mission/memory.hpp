// A memory whose power fails after any number of bytes, for tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>

#include "mission_sim.hpp"  // includes mission_store.hpp

namespace stator::drivers::mission {

// Only what was written takes room.
struct Memory {
    static constexpr uint64_t kNoCut = UINT64_MAX;

    std::map<uint32_t, uint8_t> bytes;
    uint64_t written = 0;
    uint64_t cut_after = kNoCut;  // so many bytes; then nothing is written any more
    bool answers = true;

    bool put(uint32_t address, std::span<const uint8_t> data) {
        if (!answers) return false;
        for (const uint8_t byte : data) {
            if (written >= cut_after) return false;
            ++written;
            bytes[address++] = byte;
        }
        return true;
    }
    bool get(uint32_t address, std::span<uint8_t> data) const {
        if (!answers) return false;
        for (uint8_t& byte : data) {
            const auto found = bytes.find(address++);
            byte = found == bytes.end() ? 0 : found->second;
        }
        return true;
    }
};

struct MemoryPort {
    bool read(uint32_t address, std::span<uint8_t> data) { return memory->get(address, data); }
    bool write(uint32_t address, std::span<const uint8_t> data) {
        return memory->put(address, data);
    }
    Memory* memory;
};

using Store = MissionStore<MemoryPort>;

inline StoredItem item_of(int32_t x) {
    return {.command = 16,
            .frame = 3,
            .autocontinue = 1,
            .param1 = 1.0F,
            .param2 = 2.0F,
            .param3 = 3.0F,
            .param4 = 4.0F,
            .x = x,
            .y = 7,
            .z = 5.0F};
}

}  // namespace stator::drivers::mission
