// The memory that a reset does not clear, and its seal.
#pragma once

#include "stator/fault_record.hpp"

namespace stator {

struct KeptRecord {
    uint32_t magic;
    uint32_t crc;  // of the record
    FaultRecord record;
};
static_assert(sizeof(KeptRecord) <= 512);  // as the generated linker script reserves
extern "C" KeptRecord stator_kept_record;

// Adds what does not depend on how the run ended.
void add_run(FaultRecord& record);
// Makes the record valid for the next run.
void seal(KeptRecord& kept);

// The record of a run that ends here; if one is being made already, ends at once.
FaultRecord& begin_fault_record(FaultRecord::Cause cause);
// `frame`: where the processor left the registers of what was interrupted.
void add_registers(FaultRecord& record, const uint32_t* frame);
// Seals the record, makes the motors safe, and resets.
[[noreturn]] void end_run(FaultRecord& record);

}  // namespace stator
