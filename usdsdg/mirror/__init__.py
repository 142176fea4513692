"""Mirrors of assets roots that are URLs: what a stage needs is copied to the user's cache folder, once and verified.

mirror/
  blobs/ab/ab12....usd      each content once, named by its SHA-256
  partial/                  downloads that go on where they ended
  locks/                    one process downloads a file, the others wait for it
  roots/HOST-HASH/
    files/Isaac/...         the mirror: links to blobs; a file is there once all that it refers to is there
    records/Isaac/...json   hash, size and ETag of each file
"""
