#include "chip/block.hpp"

#include <cstdio>
#include <utility>

#include "chip/chip.hpp"

namespace stator::chip {

std::string hex(uint32_t value) {
    char text[11];
    std::snprintf(text, sizeof text, "0x%08X", value);
    return text;
}

Block::Block(Chip& chip, std::string name, uint32_t base, uint32_t size, std::span<const Row> rows,
             Gate gate, Widths widths)
    : chip_(chip),
      name_(std::move(name)),
      base_(base),
      size_(size),
      rows_(rows),
      gate_(gate),
      widths_(widths),
      words_(size / 4) {
    Block::reset();
}

void Block::reset() {
    for (const Row& row : rows_) {
        for (unsigned i = 0; i < row.count; ++i) at(row.offset + 4 * i) = row.reset;
    }
}

uint32_t& Block::at(uint32_t offset) {
    return words_.at(offset / 4);
}

void Block::refuse(const std::string& what) const {
    throw Violation(name_ + ": " + what);
}

std::string Block::name_of(uint32_t offset) const {
    const Row* row = row_of(offset);
    if (row == nullptr) return name_ + " offset " + hex(offset);
    std::string name = name_ + "_" + row->name;
    if (row->count > 1) name += std::to_string((offset - row->offset) / 4);
    return name;
}

const Row* Block::row_of(uint32_t offset) const {
    for (const Row& row : rows_) {
        if (offset >= row.offset && offset < row.offset + 4 * row.count) return &row;
    }
    return nullptr;
}

void Block::check_width(uint32_t offset, unsigned bytes) const {
    if ((bytes & widths_) == 0 || offset % bytes != 0) {
        refuse("an access of " + std::to_string(bytes) + " bytes at " + name_of(offset & ~3U));
    }
    if (row_of(offset & ~3U) == nullptr) {
        refuse("offset " + hex(offset) + " has no register, or it is not modelled");
    }
}

uint32_t Block::read(uint32_t offset, unsigned bytes) {
    check_width(offset, bytes);
    const uint32_t word = on_read(offset & ~3U);
    return bytes == 4 ? word : word >> 8 * (offset & 3U) & ((1U << 8 * bytes) - 1);
}

void Block::write(uint32_t offset, uint32_t value, unsigned bytes) {
    check_width(offset, bytes);
    const uint32_t word = offset & ~3U;
    const Row& row = *row_of(word);
    if (bytes != 4) {
        const uint32_t shift = 8 * (offset & 3U);
        const uint32_t mask = ((1U << 8 * bytes) - 1) << shift;
        value = (at(word) & ~mask) | (value << shift & mask);
    }
    const uint32_t reserved = ~(row.writable | row.read_only);
    if (((value ^ row.reset) & reserved) != 0) {
        refuse("reserved bits of " + name_of(word) + ": expected " + hex(row.reset & reserved) +
               ", found " + hex(value & reserved));
    }
    on_write(word, (value & row.writable) | (at(word) & ~row.writable));
}

}  // namespace stator::chip
