// The record of a run that failed: what all records hold, its seal, and how the next run takes it.
#include "stator/fault_record.hpp"

#include <algorithm>
#include <cstring>

#include "stator/activation.hpp"
#include "stator/cortex_m.hpp"
#include "stator/crc32.hpp"
#include "stator/kept_record.hpp"

// The note that the linker makes of the build (--build-id): a header of 16 bytes, then the hash.
extern "C" {
extern const uint8_t stator_build_id_begin[];
extern const uint8_t stator_build_id_end[];
}

namespace stator {

namespace {

constexpr uint32_t kMagic = 0x53544154;  // "TATS"
constexpr ptrdiff_t kNoteHeader = 16;

void copy_build_id(FaultRecord& record) {
    const ptrdiff_t bytes = stator_build_id_end - stator_build_id_begin - kNoteHeader;
    if (bytes <= 0) return;
    std::memcpy(record.build_id.data(), stator_build_id_begin + kNoteHeader,
                std::min<size_t>(static_cast<size_t>(bytes), record.build_id.size()));
}

// A run that outlived the window starts a new count.
void count_reset(FaultRecord& record) {
    const uint64_t window_us = last_fault_record.window_us + record.uptime_us;
    const bool is_row = last_fault_record.resets != 0 && window_us <= kResetWindow_us;
    record.resets = is_row ? last_fault_record.resets + 1 : 1;
    record.window_us = is_row ? window_us : 0;
}

uint32_t first_silent_task() {
    for (unsigned i = 0; i < program.watched_count; ++i) {
        const Watched& row = program.watched[i];
        if (row.state->is_silent) return row.task + 1;
    }
    return 0;
}

}  // namespace

FaultRecord last_fault_record;
ActivationRing activation_ring;

void add_run(FaultRecord& record) {
    record.uptime_us = clock_us();
    record.silent_task = first_silent_task();
    record.activation_count = activation_ring.count.load();
    record.activations = activation_ring.entries;
    std::memcpy(record.graph_hash.data(), program.graph_hash, record.graph_hash.size());
    copy_build_id(record);
    count_reset(record);
}

void seal(KeptRecord& kept) {
    kept.crc = crc32_bitwise(&kept.record, sizeof kept.record);
    kept.magic = kMagic;
    barrier();
}

void take_fault_record() {
    const bool is_whole =
        stator_kept_record.magic == kMagic &&
        stator_kept_record.crc == crc32_bitwise(&stator_kept_record.record, sizeof(FaultRecord));
    last_fault_record = is_whole ? stator_kept_record.record : FaultRecord{};
    stator_kept_record.magic = 0;
}

}  // namespace stator
