// A memory whose power fails after any number of bytes, for tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "nonvolatile_sim.hpp"  // includes record_store.hpp

namespace stator::drivers::nonvolatile {

struct Memory {
    static constexpr uint64_t kNoCut = UINT64_MAX;

    explicit Memory(uint8_t blank = 0) : bytes(16384, blank) {}

    std::vector<uint8_t> bytes;
    uint64_t written = 0;
    uint64_t cut_after = kNoCut;  // so many bytes; then nothing is written any more
    bool spoils_last = false;     // the byte at which power fails is neither old nor new
    bool answers = true;

    bool is_cut() const { return written >= cut_after; }
    bool put(uint32_t address, std::span<const uint8_t> data) {
        if (!answers) return false;
        for (const uint8_t byte : data) {
            if (is_cut()) return false;
            ++written;
            bytes.at(address++) = is_cut() && spoils_last ? uint8_t(byte ^ 0x5A) : byte;
        }
        return true;
    }
};

struct MemoryPort {
    bool read(uint32_t address, std::span<uint8_t> data) {
        if (!memory->answers) return false;
        std::copy_n(memory->bytes.begin() + address, data.size(), data.begin());
        return true;
    }
    bool write(uint32_t address, std::span<const uint8_t> data) {
        return memory->put(address, data);
    }
    Memory* memory;
};

using Store = RecordStore<MemoryPort>;

inline StoredRecord record_of(uint32_t key, uint8_t value) {
    StoredRecord record{.key = key, .kind = StoredRecord::Kind::kParameter, .length = 9};
    std::fill_n(record.data.begin(), record.length, value);
    return record;
}

}  // namespace stator::drivers::nonvolatile
