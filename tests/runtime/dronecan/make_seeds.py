"""Makes the folder seeds/ of the fuzzer: good transfers of every type, as frames.

.venv/bin/python tests/runtime/dronecan/make_seeds.py FOLDER
"""

from __future__ import annotations

import random
import struct
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "codegen"), str(Path(__file__).parent)]

from dronecan.transport import Transfer  # noqa: E402
from dronecan_values import limits, make, modes, service_or_message  # noqa: E402

from stator.build.dronecan_codecs import TYPES  # noqa: E402

OWN_ID = 10


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name in TYPES:
        kind = service_or_message(name)
        for mode in modes(kind):
            for case in range(3):
                draw = random.Random(f"{name}{mode}{case}")

                def primitive(of: object, draw: random.Random = draw) -> object:
                    return draw.choice(limits(of))

                value = make(
                    kind,
                    mode,
                    primitive,
                    lambda most, draw=draw: draw.randint(0, most),
                    lambda count, draw=draw: draw.randrange(count),
                )
                transfer = Transfer(
                    transfer_id=case,
                    source_node_id=20 + case,
                    dest_node_id=OWN_ID if mode else None,
                    payload=value,
                    service_not_message=mode is not None,
                    request_not_response=mode == "request",
                )
                records = b"".join(
                    struct.pack("<IBB8sxx", f.message_id, 1, len(f.bytes), bytes(f.bytes))
                    for f in transfer.to_frames()
                )
                (folder / f"{name}-{mode or 'message'}-{case}").write_bytes(records)


main(Path(sys.argv[1]))
