"""Why a listener feels nothing."""
