// Plays a baked pack of Haptic Tracing without a server. Needs HapticTracing.cs, for its JSON.

using System;
using System.Collections.Generic;
using System.IO;

namespace HapticTracing
{
    /// <summary>A blow of the bake: its objects, its time in seconds, its place in the axes of glTF and its energy in joules.</summary>
    public sealed class Blow
    {
        public string First, Second;
        public double Time, Energy;
        public double[] Position;
        internal double FullEnergy;
        internal Dictionary<string, float[]> Felt;
    }

    /// <summary>What listeners feel: the tracks of the bake, and whatever blows and one-shots happen, from the table of the bake.</summary>
    public sealed class Pack
    {
        const double LevelSeconds = 0.25;

        sealed class Sound
        {
            public long First;
            public double Factor;
            public Dictionary<string, float[]> Felt;
        }

        readonly Dictionary<string, float[]> tracks = new Dictionary<string, float[]>(), recent = new Dictionary<string, float[]>();
        readonly Dictionary<string, double> ceilings = new Dictionary<string, double>();
        readonly Dictionary<string, string> materials = new Dictionary<string, string>();
        readonly Dictionary<string, Dictionary<string, float[]>> shots = new Dictionary<string, Dictionary<string, float[]>>();
        readonly List<string> limits = new List<string>();
        readonly List<Blow> blows = new List<Blow>();
        readonly List<KeyValuePair<string, double>> baked = new List<KeyValuePair<string, double>>();
        readonly List<Sound> sounds = new List<Sound>();
        readonly long length;
        long played;

        public readonly double SampleRate;
        /// <summary>Whether the tracks begin again at their end.</summary>
        public bool Loops;
        /// <summary>What a pack cannot do.</summary>
        public IReadOnlyList<string> Limits { get { return limits; } }
        public IReadOnlyList<Blow> Blows { get { return blows; } }
        /// <summary>The sources that played once in the bake, each with its time in seconds.</summary>
        public IReadOnlyList<KeyValuePair<string, double>> Shots { get { return baked; } }
        public IEnumerable<string> Listeners { get { return tracks.Keys; } }

        public Pack(string json)
        {
            var form = (Dictionary<string, object>)Json.Read(json);
            if ((string)form["format"] != "haptic-pack" || !((string)form["version"]).StartsWith("1.")) throw new InvalidDataException("not a haptic pack of version 1");
            SampleRate = (double)form["sample_rate"];
            length = (long)(double)form["samples"];
            foreach (string limit in (List<object>)form["limits"]) limits.Add(limit);
            foreach (var pair in (Dictionary<string, object>)form["materials"]) materials[pair.Key] = (string)pair.Value;
            foreach (var pair in Samples(form["tracks"])) tracks[pair.Key] = pair.Value;
            foreach (Dictionary<string, object> listener in (List<object>)form["listeners"])
            {
                var name = (string)listener["name"];
                ceilings[name] = (double)listener["s_max"];
                recent[name] = new float[(int)Math.Round(LevelSeconds * SampleRate)];
            }
            foreach (Dictionary<string, object> row in (List<object>)form["blows"])
            {
                var objects = (List<object>)row["objects"];
                blows.Add(new Blow
                {
                    First = (string)objects[0],
                    Second = (string)objects[1],
                    Time = (double)row["time"],
                    Energy = (double)row["energy"],
                    FullEnergy = (double)row["full_energy"],
                    Position = ((List<object>)row["position"]).ConvertAll(value => (double)value).ToArray(),
                    Felt = Samples(row["felt"])
                });
            }
            foreach (Dictionary<string, object> row in (List<object>)form["one_shots"])
            {
                var source = (string)row["source"];
                baked.Add(new KeyValuePair<string, double>(source, (double)row["time"]));
                if (!shots.ContainsKey(source)) shots[source] = Samples(row["felt"]);
            }
        }

        /// <summary>The seconds that have been played.</summary>
        public double Time { get { return played / SampleRate; } }

        /// <summary>The material of an object that comes at run time, for its blows.</summary>
        public void SetMaterial(string name, string material) { materials[name] = material; }

        /// <summary>Two objects hit each other: time in seconds of the pack, from Time on; position in the axes of glTF. False if the table has nothing for them.</summary>
        public bool Hit(string first, string second, double energy, double[] position, double time)
        {
            var row = Nearest(position, blow => Alike(blow.First, blow.Second, first, second));
            string a, b;
            if (row == null && materials.TryGetValue(first, out a) && materials.TryGetValue(second, out b))
                row = Nearest(position, blow => Alike(materials[blow.First], materials[blow.Second], a, b));
            if (row == null) return false;
            Begin(row.Felt, time, Math.Min(energy / row.FullEnergy, 1) / Math.Min(row.Energy / row.FullEnergy, 1));
            return true;
        }

        /// <summary>Play a source with triggers once. False if it was not heard in the bake.</summary>
        public bool Play(string source, double time)
        {
            Dictionary<string, float[]> felt;
            if (!shots.TryGetValue(source, out felt)) return false;
            Begin(felt, time, 1);
            return true;
        }

        /// <summary>Go on to a time in seconds. Returns the samples since the last call, by listener.</summary>
        public Dictionary<string, float[]> Advance(double time)
        {
            var end = Index(time);
            var blocks = new Dictionary<string, float[]>();
            foreach (var pair in tracks)
            {
                var block = new float[Math.Max(end - played, 0)];
                for (var k = 0; k < block.Length; k++)
                {
                    var sample = Loops && length > 0 ? (played + k) % length : played + k;
                    double sum = sample < pair.Value.Length ? pair.Value[sample] : 0;
                    foreach (var sound in sounds)
                    {
                        float[] felt;
                        var at = played + k - sound.First;
                        if (at >= 0 && sound.Felt.TryGetValue(pair.Key, out felt) && at < felt.Length) sum += sound.Factor * felt[at];
                    }
                    var ceiling = ceilings[pair.Key];
                    block[k] = (float)Math.Max(Math.Min(sum, ceiling), -ceiling);
                    recent[pair.Key][(played + k) % recent[pair.Key].Length] = block[k];
                }
                blocks[pair.Key] = block;
            }
            played = Math.Max(end, played);
            sounds.RemoveAll(IsOver);
            return blocks;
        }

        /// <summary>The level of the last quarter second, without its mean.</summary>
        public Level LevelAt(string listener)
        {
            double energy = 0, mean = 0;
            foreach (double sample in recent[listener])
            {
                energy += sample * sample;
                mean += sample;
            }
            var rest = energy - mean * mean / recent[listener].Length;
            var count = Math.Max(Math.Min(played, recent[listener].Length), 1);
            return new Level { Decibels = rest > 1e-12 * energy ? 10 * Math.Log10(rest / count) : double.NaN, Margin = double.NaN };
        }

        void Begin(Dictionary<string, float[]> felt, double time, double factor)
        {
            sounds.Add(new Sound { First = Math.Max(Index(time), played), Factor = factor, Felt = felt });
        }

        bool IsOver(Sound sound)
        {
            foreach (var felt in sound.Felt.Values)
                if (sound.First + felt.Length > played) return false;
            return true;
        }

        Blow Nearest(double[] position, Predicate<Blow> fits)
        {
            Blow best = null;
            var least = double.PositiveInfinity;
            foreach (var blow in blows)
            {
                if (!fits(blow)) continue;
                double distance = 0;
                for (var k = 0; k < 3; k++) distance += (blow.Position[k] - position[k]) * (blow.Position[k] - position[k]);
                if (distance >= least) continue;
                least = distance;
                best = blow;
            }
            return best;
        }

        /// <summary>The first sample that is not before a time, a millionth of a sample of rounding forgiven.</summary>
        long Index(double time) { return (long)Math.Ceiling(time * SampleRate - 1e-6); }

        static bool Alike(string a, string b, string c, string d) { return (a == c && b == d) || (a == d && b == c); }

        static Dictionary<string, float[]> Samples(object form)
        {
            var found = new Dictionary<string, float[]>();
            foreach (var pair in (Dictionary<string, object>)form)
            {
                var bytes = Convert.FromBase64String((string)pair.Value);
                found[pair.Key] = new float[bytes.Length / 4];
                Buffer.BlockCopy(bytes, 0, found[pair.Key], 0, bytes.Length);
            }
            return found;
        }
    }
}
