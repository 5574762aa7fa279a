"""Live output: what listeners feel goes to devices and loudspeakers while the timeline plays, and stops when anything else happens."""
