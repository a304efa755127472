// What the backup supply keeps: the registers of the clock's block, and 4 KB (RM0090, 5.1.2, 26.6).
#pragma once

#include "chip/block.hpp"
#include "chip/clocks.hpp"

namespace stator::chip {

// Of the real-time clock, the backup registers only.
class Backup : public Block {
  public:
    Backup(Chip& chip, const PowerControl& power);
    void reset() override {}

  private:
    void on_write(uint32_t offset, uint32_t value) override;
    const PowerControl& power_;
};

class BackupRam : public Block {
  public:
    BackupRam(Chip& chip, const PowerControl& power);
    void reset() override {}

  private:
    void on_write(uint32_t offset, uint32_t value) override;
    const PowerControl& power_;
};

}  // namespace stator::chip
