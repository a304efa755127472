// Memory protection: what no code may do faults at once. All code is privileged; where no region
// says otherwise the default map holds. DDI 0403E, B3.5.
#include "stator/cortex_m.hpp"
#include "stator/guard_region.hpp"

// Laid out by the generated linker script.
extern "C" {
extern const uint32_t stator_flash_begin[];
extern const uint32_t stator_flash_bytes[];  // its address is the number
}

namespace stator {

namespace {

// Access of a region, as its attribute register has it (B3.5.9).
constexpr uint32_t kNoAccess = 1U << 28;                          // and no execution
constexpr uint32_t kReadOnly = (6U << 24) | (1U << 17);           // and execution; cacheable
constexpr uint32_t kData = (1U << 28) | (3U << 24) | (3U << 17);  // no execution; shareable
constexpr uint32_t kEnable = 1U << 0;
constexpr uint32_t kHalfGigabyte = 0x20000000;

void guard(uint32_t number, const GuardRegion& region, uint32_t access) {
    mpu::kRegion.write(number);
    mpu::kBase.write(region.base);
    mpu::kAttributes.write(access | region.size_fields() | kEnable);
}

}  // namespace

void guard_memory() {
    // Of the alias of the flash at 0, which nothing needs after the reset; of what lies below the
    // stack at 0x10000000; the flash; the rest of the code area, with the stack; the RAM.
    guard(0, region_around(0x00000000, 0x08000000), kNoAccess);
    guard(1, region_around(0x0C000000, 0x04000000), kNoAccess);
    guard(2,
          region_around(reinterpret_cast<uint32_t>(stator_flash_begin),
                        reinterpret_cast<uint32_t>(stator_flash_bytes)),
          kReadOnly);
    guard(3, region_around(0x10000000, 0x10000000), kData);
    guard(4, region_around(0x20000000, kHalfGigabyte), kData);
    // Off in HardFault: a fault there would stop the processor.
    mpu::kControl.write(mpu::kEnable | mpu::kDefaultMap);
    barrier();
}

}  // namespace stator
