-- Seeds and numbers of episodes are below 2^63, the greatest whole number of SQLite.
CREATE TABLE batch(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE episodes(
  episode INTEGER PRIMARY KEY,
  variant TEXT NOT NULL,
  point INTEGER NOT NULL,
  seed INTEGER NOT NULL,
  status TEXT NOT NULL,
  outcome TEXT NOT NULL,
  state_hash TEXT NOT NULL,
  simulated_s REAL,
  message TEXT NOT NULL,
  command TEXT NOT NULL);
CREATE TABLE parameters(episode INTEGER, name TEXT, value TEXT, PRIMARY KEY(episode, name)) WITHOUT ROWID;
CREATE TABLE metrics(episode INTEGER, position INTEGER, name TEXT NOT NULL, vehicle TEXT NOT NULL, value REAL, unit TEXT,
  text TEXT, PRIMARY KEY(episode, position)) WITHOUT ROWID;
CREATE TABLE timing(episode INTEGER PRIMARY KEY, host TEXT, setup_wall_s REAL, flight_wall_s REAL, wall_s REAL,
  built_world INTEGER);
CREATE VIEW failures AS SELECT episode, variant, seed, status, message, command FROM episodes WHERE status <> 'done';
