// What the models of all peripherals have in common: registers with their reset values and reserved
// bits, a clock that can be off, and a time at which something happens by itself.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "chip/violation.hpp"

namespace stator::chip {

class Chip;

inline constexpr uint64_t kNever = UINT64_MAX;

// A register: its place, and what its bits are. Bits that are neither writable nor read-only are
// reserved and must be written with their reset value.
struct Row {
    uint32_t offset;
    const char* name;
    uint32_t reset = 0;
    uint32_t writable = 0;
    uint32_t read_only = 0;  // a write has no effect
    unsigned count = 1;      // of such registers, one behind the other
};

// The bit of a register of the reset and clock control that switches a peripheral on. Offset 0: it
// is always on.
struct Gate {
    uint32_t offset = 0;
    unsigned bit = 0;
};

// Sizes of an access, in bytes.
enum Widths : unsigned { kWords = 4, kHalfWordsAndWords = 6, kAllWidths = 7 };

class Block {
  public:
    Block(Chip& chip, std::string name, uint32_t base, uint32_t size, std::span<const Row> rows,
          Gate gate, Widths widths);
    virtual ~Block() = default;
    Block(const Block&) = delete;
    Block& operator=(const Block&) = delete;

    const std::string& name() const { return name_; }
    uint32_t base() const { return base_; }
    uint32_t size() const { return size_; }
    Gate gate() const { return gate_; }

    uint32_t read(uint32_t offset, unsigned bytes);
    void write(uint32_t offset, uint32_t value, unsigned bytes);
    virtual void reset();

    // When something happens by itself, and what; `run` comes at that time exactly.
    virtual uint64_t due_ns() const { return kNever; }
    // When that may reach the processor, by a line or a register; not before `due_ns`.
    virtual uint64_t visible_ns() const { return due_ns(); }
    virtual void run() {}
    // Whether reads have no effect, and give the same until `visible_ns` or a write.
    virtual bool is_constant() const { return false; }
    // Before the clocks change: what was counted so far counts at the old rate.
    virtual void settle() {}

  protected:
    // What a read gives, and what a write does besides being kept. `offset` is of a register; a
    // write has the reserved bits right.
    virtual uint32_t on_read(uint32_t offset) { return at(offset); }
    virtual void on_write(uint32_t offset, uint32_t value) { at(offset) = value; }

    uint32_t& at(uint32_t offset);
    uint32_t at(uint32_t offset) const { return const_cast<Block*>(this)->at(offset); }
    bool has(uint32_t offset, uint32_t bits) const { return (at(offset) & bits) != 0; }
    [[noreturn]] void refuse(const std::string& what) const;
    std::string name_of(uint32_t offset) const;

    Chip& chip_;

  private:
    const Row* row_of(uint32_t offset) const;
    void check_width(uint32_t offset, unsigned bytes) const;

    std::string name_;
    uint32_t base_;
    uint32_t size_;
    std::span<const Row> rows_;
    Gate gate_;
    Widths widths_;
    std::vector<uint32_t> words_;
};

std::string hex(uint32_t value);

}  // namespace stator::chip
