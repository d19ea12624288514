"""One file per verb: tables in, a frozen result out; no disk, no terminal."""
