"""Gives the rows of a campaign to a Dask cluster, and takes the results as they come."""

from __future__ import annotations

import contextlib
import logging
import tempfile
from itertools import islice
from typing import TYPE_CHECKING, Any

from stator.campaign.worker import Delivery, fly_row
from stator.diagnostics import UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from distributed import Client

    from stator.campaign.draw import Row
    from stator.campaign.worker import Kit

# So many rows wait at each worker: enough for it never to wait, and few for the scheduler's memory.
WAITING = 8
MOST_DEATHS = 5  # of workers, while they fly the same row
CONNECT = "20 s"


@contextlib.contextmanager
def cluster(address: str | None, workers: int) -> Iterator[Client]:
    """A client of the cluster at `address`; without one, of processes of this machine."""
    import dask
    from distributed import Client, LocalCluster

    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    settings = {
        "distributed.scheduler.allowed-failures": MOST_DEATHS,
        "distributed.comm.timeouts.connect": CONNECT,
        "distributed.admin.low-level-log-length": 0,
    }
    with dask.config.set(settings):
        if address is not None:
            try:
                client = Client(address)
            except (OSError, ValueError) as failed:
                raise UserError(
                    f"error: cannot connect to the cluster '{address}': {failed}\n"
                    "hint: start one with `dask scheduler`, and give the address that it prints"
                ) from None
            with client:
                yield client
            return
        with (
            tempfile.TemporaryDirectory(prefix="stator-campaign-") as folder,
            LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                memory_limit=0,
                dashboard_address="127.0.0.1:0",
                local_directory=folder,
                silence_logs=logging.CRITICAL,
            ) as local,
            Client(local) as client,
        ):
            yield client


def fly_all(
    client: Client, kit: Kit, rows: Iterable[Row], take: Callable[[str], None]
) -> list[str]:
    """Hands each result, in any order, to `take`. Returns why rows were not flown."""
    from distributed import as_completed

    delivery = Delivery(kit)
    sha256 = kit.sha256
    try:
        client.register_plugin(delivery, name=delivery.name)
    except RuntimeError as failed:
        raise UserError(str(failed)) from None
    left = iter(rows)
    missed = []
    try:

        def submit(row: Row) -> Any:
            return client.submit(fly_row, sha256, row, pure=False, retries=1)

        waiting = WAITING * max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)
        running = as_completed(map(submit, islice(left, waiting)), with_results=False)
        for future in running:
            if future.status == "finished":
                take(future.result())
            else:
                missed.append(str(future.exception()))
            future.release()
            for row in islice(left, 1):
                running.add(submit(row))
    finally:
        with contextlib.suppress(Exception):
            client.unregister_worker_plugin(delivery.name)
    return missed
