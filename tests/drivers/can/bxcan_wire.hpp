// Connects the bxCAN driver to the model of its registers, and makes frames for both.
#pragma once

#include "bxcan_model.hpp"
#include "bxcan_port.hpp"

namespace stator::testing {

using drivers::can::CanSend;
using namespace drivers::can::bxcan;
namespace bxcan = drivers::can::bxcan;

// What the port is given in place of the chip's registers.
struct BxcanWire {
    BxcanModel* model;
    uint32_t read(uint32_t offset) const { return model->read(offset); }
    void write(uint32_t offset, uint32_t value) const { model->write(offset, value); }
};

inline CanFrame frame(uint32_t id, uint64_t timestamp, uint8_t first = 0) {
    return {.timestamp = timestamp,
            .id = id,
            .extended = true,
            .length = 8,
            .data = {first, 2, 3, 4, 5, 6, 7, 8}};
}
inline BxcanModel::Message message(uint32_t id) {
    return {id << 3 | 1U << 2, 8, {0x04030201, 0x08070605}};
}

}  // namespace stator::testing
